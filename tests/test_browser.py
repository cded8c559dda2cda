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
