"""Files that a browser holds already are asked for again, and not sent again."""

import pytest

from app.shared.resources import Resources

from .conftest import served


@pytest.mark.parametrize("path", ["web/shared/page.css", "frames"])
def test_a_file_that_the_browser_holds_as_it_is_now_is_not_sent_again(framed, path):
    client = served(Resources(framed))
    first = client.get(f"/omnivat/{path}")
    held = {"If-None-Match": first.headers["etag"]}
    again = client.get(f"/omnivat/{path}", headers=held)
    assert (first.status_code, again.status_code, again.content) == (200, 304, b"")
    if path == "frames":
        assert first.content == framed.frames.read_bytes()
        assert first.headers["x-frames"] == "fine"
    for name in ("etag", "cache-control", "x-holds", "x-frames"):
        assert again.headers.get(name) == first.headers.get(name)
    assert client.get(f"/omnivat/{path}", headers={"If-None-Match": '"other"'}).status_code == 200
