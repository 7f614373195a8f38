"""What holds of the HTML of every page: its tags balance, and it loads nothing."""

from html.parser import HTMLParser


class Outline(HTMLParser):
    """Notes what a page loads and whether its tags balance."""

    VOID = ("meta", "link", "br", "input", "img")
    SHORT = ("td", "tr")
    """Elements that HTML lets end without a tag, as the long lists do."""

    def __init__(self):
        super().__init__()
        self.open, self.loaded = [], []

    def handle_starttag(self, tag, attrs):
        if tag not in self.VOID:
            self.open.append(tag)
        self.loaded += [v for k, v in attrs if k in ("src", "href", "xlink:href") and not v.startswith(("#", "data:"))]

    def handle_endtag(self, tag):
        while tag not in self.SHORT and self.open[-1] in self.SHORT:
            self.open.pop()
        while tag == "tr" and self.open[-1] == "td":
            self.open.pop()
        assert self.open.pop() == tag


def check_outline(html):
    """Assert that the tags of a page balance and that it loads nothing from elsewhere."""
    outline = Outline()
    outline.feed(html)
    assert outline.open == []
    assert outline.loaded == []
    assert "@import" not in html
