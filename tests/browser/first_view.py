"""What a visitor sees first: words, the map's share of the window, margins, letters."""

# Words and letters count if they are in the window. A figure and its unit are one word.
LOOK = """() => {
  const seen = (e) => {
    const b = e.getBoundingClientRect();
    const shown = e.checkVisibility({ visibilityProperty: true, contentVisibilityAuto: true });
    return shown && b.width > 1 && b.height > 1 && b.bottom > 0 && b.top < innerHeight
      && b.right > 0 && b.left < innerWidth;
  };
  const texts = [];
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const { parentElement: of, textContent: text } = walk.currentNode;
    if (!text.trim() || of.closest('script, style, option, .sr, .visually-hidden')) continue;
    const range = document.createRange();
    range.selectNodeContents(walk.currentNode);
    const b = range.getBoundingClientRect();
    if (seen(of) && b.width > 1 && b.top < innerHeight && b.bottom > 0) texts.push([of,
      text.trim()]);
  }
  const size = (e) =>
    parseFloat(getComputedStyle(e).fontSize) * (e.ownerSVGElement?.getScreenCTM().a ?? 1);
  const seenOf = (parts) =>
    [...document.querySelectorAll(parts)].find((e) => e.checkVisibility()).getBoundingClientRect();
  const map = seenOf('.explore :is(.map, .twin-pictures)');
  const all = seenOf('.explore > :is(.stage, .touch)');
  const high = Math.min(innerHeight, map.bottom) - Math.max(0, map.top);
  return {
    words: texts.flatMap(([, text]) => text.match(/\\p{L}[^\\s]*/gu) ?? []).length,
    smallest: Math.min(...texts.map(([e]) => size(e))),
    small: texts.filter(([e]) => size(e) < 13.95).map(([, text]) => text).slice(0, 8),
    map: (map.width * high) / (innerWidth * innerHeight),
    left: all.left,
    right: document.documentElement.clientWidth - all.right,
  };
}"""
