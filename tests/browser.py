"""A real headless Chromium without network, for the tests of the pages that avobench writes."""

import os
import shutil

import pytest
from selenium import webdriver

FLAGS = ("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking")
OFFLINE = "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"  # the driver talks to the browser by 127.0.0.1


class Browser:
    """One window. `driver` is Selenium's; `open` shows a file, `complaints` tells what the page did wrong."""

    def __init__(self, driver):
        self.driver = driver

    def open(self, path):
        self.complaints()  # those of an earlier page
        self.driver.get(path.resolve().as_uri())

    def run(self, script, *arguments):
        """The value that JavaScript in the page returns."""
        return self.driver.execute_script(script, *arguments)

    def complaints(self):
        """Errors and warnings in the console since the last call, and whatever was asked of any network."""
        asked = self.run("return performance.getEntriesByType('resource').map(entry => entry.name)")
        lines = [
            entry["message"] for entry in self.driver.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")
        ]
        return lines + [f"asked for {name}" for name in asked if not name.startswith(("data:", "blob:"))]


@pytest.fixture(scope="session")
def browser():
    """Debian's `chromium` with `chromium-driver`; with AVOBENCH_BROWSER=required its absence is a failure."""
    chromium, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if not (chromium and driver):
        told = pytest.fail if os.environ.get("AVOBENCH_BROWSER") == "required" else pytest.skip
        told("needs chromium and chromedriver (`make browser` as root, or apt-get install chromium chromium-driver)")
    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    for flag in (*FLAGS, OFFLINE, "--disable-dev-shm-usage", "--window-size=1200,900"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    window = webdriver.Chrome(options, webdriver.ChromeService(driver))
    yield Browser(window)
    window.quit()
