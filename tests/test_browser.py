"""The browser of the tests notices what it is there to notice."""


def test_the_browser_runs_scripts_and_reports_errors_and_requests(browser, tmp_path):
    page = tmp_path / "page.html"
    page.write_text("<title>t</title><h1>Hello</h1><script>document.title = 'done'</script>")
    browser.open(page)
    assert browser.driver.title == "done"
    assert browser.complaints() == []
    page.write_text("<script>console.error('wrong')</script><img src='http://example.org/a.png'>")
    browser.open(page)
    text = "\n".join(browser.complaints())
    assert "wrong" in text
    assert "example.org" in text


def test_the_browser_measures_contrast(browser, tmp_path):
    page = tmp_path / "page.html"
    page.write_text("<body style='background: #ffffff'><p style='color: #777777'>grey<p style='color: #000000'>black")
    browser.open(page)
    (grey, first), (black, second) = browser.contrasts()
    assert (first, round(grey, 2), second, round(black, 2)) == ("grey", 4.48, "black", 21)


def test_the_browser_sees_a_page_that_is_too_wide(browser, tmp_path):
    page = tmp_path / "page.html"
    page.write_text("<div style='width: 1000px; height: 10px'></div>")
    browser.open(page)
    for width, fits in ((1300, True), (800, False)):
        with browser.window(width):
            end, window = browser.widest()
            assert window == width
            assert (end <= window) == fits
