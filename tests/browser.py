"""A real headless Chromium without network, for the tests of the pages that avobench writes."""

import io
import os
import re
import shutil
from contextlib import contextmanager

import numpy as np
import pytest
from PIL import Image
from selenium import webdriver

FLAGS = ("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking")
OFFLINE = "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"  # the driver talks to the browser by 127.0.0.1


TEXTS = """
const behind = element => {
  for (; element; element = element.parentElement) {
    const colour = getComputedStyle(element).backgroundColor;
    if (colour !== "rgba(0, 0, 0, 0)") return colour;
  }
  return "rgb(255, 255, 255)";
};
const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT), found = [];
while (texts.nextNode()) {
  const words = texts.currentNode.textContent.trim(), element = texts.currentNode.parentElement;
  if (words && element.checkVisibility()) found.push([words, getComputedStyle(element).color, behind(element)]);
}
return found;
"""


def rgb(colour):
    """The parts of what a browser computes, such as `rgb(31, 35, 40)`, from 0 to 1."""
    return np.array([int(part) for part in re.fullmatch(r"rgb\((\d+), (\d+), (\d+)\)", colour).groups()]) / 255


def contrast(colour, behind):
    """The ratio of the luminances of two colours as WCAG 2.2 defines it."""
    linear = [np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4) for c in (colour, behind)]
    darker, lighter = sorted(float(c @ [0.2126, 0.7152, 0.0722]) for c in linear)
    return (lighter + 0.05) / (darker + 0.05)


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

    @contextmanager
    def _emulating(self, command, how, undo, plain):
        """Within the block the browser does what a command of the DevTools protocol says."""
        self.driver.execute_cdp_cmd(f"Emulation.{command}", how)
        try:
            yield
        finally:
            self.driver.execute_cdp_cmd(f"Emulation.{undo}", plain)

    def window(self, width, mobile=False):
        """A window of so many pixels, or a phone's screen."""
        size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": mobile}
        return self._emulating("setDeviceMetricsOverride", size, "clearDeviceMetricsOverride", {})

    def scheme(self, name):
        """A reader who prefers the colours "light" or "dark"."""
        wanted = {"features": [{"name": "prefers-color-scheme", "value": name}]}
        return self._emulating("setEmulatedMedia", wanted, "setEmulatedMedia", {"features": []})

    def without_scripts(self):
        """A reader whose browser runs no script of the pages that are opened."""
        command = "setScriptExecutionDisabled"
        return self._emulating(command, {"value": True}, command, {"value": False})

    def in_both_schemes(self):
        """Screenshots of the page in light and in dark, in which it shows the same words, and all legibly."""
        words, shots = set(), []
        for name in ("light", "dark"):
            with self.scheme(name):
                faintest, text = self.contrasts()[0]
                assert faintest >= 4.5, text
                words.add(self.run("return document.body.innerText"))
                shots.append(self.screenshot())
        assert len(words) == 1
        return shots

    def screenshot(self):
        """What the window shows: (height, width, 3), from 0 to 255."""
        return np.array(Image.open(io.BytesIO(self.driver.get_screenshot_as_png())).convert("RGB"))

    def widest(self):
        """Right end of the page in pixels, and the width of the window: the page scrolls where it is larger."""
        return self.run("return [document.scrollingElement.scrollWidth, innerWidth]")

    def require_fit(self, width):
        """A window of so many pixels needs no horizontal scrollbar, a wide one none in a table, and it is used."""
        with self.window(width, mobile=width < 400):
            end, window = self.widest()
            assert end <= window == width
            scrolled = (
                "[...document.querySelectorAll('section .scroll')].some(box => box.scrollWidth > box.clientWidth)"
            )
            assert width < 1300 or not self.run(f"return {scrolled}")
            main, *figures = self.run(
                "return [...document.querySelectorAll('main, figure')].map(part => part.clientWidth)"
            )
            assert main > 0.95 * width
            assert all(figure <= width for figure in figures)

    def contrasts(self):
        """Of every text, its contrast with what is behind it, 1 (unseen) to 21, and its words; the faintest first."""
        return sorted((contrast(rgb(colour), rgb(behind)), text) for text, colour, behind in self.run(TEXTS))

    def complaints(self):
        """Errors and warnings in the console since the last call, and whatever was asked of any network."""
        asked = self.run("return performance.getEntriesByType('resource').map(entry => entry.name)")
        log = self.driver.get_log("browser")
        lines = [entry["message"] for entry in log if entry["level"] in ("SEVERE", "WARNING")]
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
