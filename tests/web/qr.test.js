import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import test from "node:test";
import { checks, qr } from "../../app/web/shared/qr.js";

const LINK = "https://uni.example/~lab/touch%20site/?chapter=analyse&p=0.35&sel=1~2";

test("a code of each size is the one that a reader decoded to the same text", () => {
  const of = (text) =>
    createHash("sha256")
      .update(JSON.stringify(qr(text).map((row) => row.map(Number))))
      .digest("hex")
      .slice(0, 12);
  const texts = [17, 69, 300, 800].map((bytes) => LINK.repeat(20).slice(0, bytes));
  assert.deepEqual(
    texts.map((text) => [qr(text).length, of(text)]),
    [
      [21, "6bfb83214ab2"],
      [33, "8287751a8060"],
      [61, "2909dcde2503"],
      [97, "2271ec74ef87"],
    ],
  );
});

test("check bytes make the block a multiple of its divisor: each power of two is a root", () => {
  const times = (a, b) => {
    let product = 0;
    for (let i = 0; i < 8; i++) {
      if ((b >> i) & 1) product ^= a << i;
    }
    for (let i = 14; i > 7; i--) if ((product >> i) & 1) product ^= 0x11d << (i - 8);
    return product;
  };
  const block = [...new TextEncoder().encode(LINK)];
  const whole = [...block, ...checks(block, 20)];
  for (let power = 0, root = 1; power < 20; power++, root = times(root, 2))
    assert.equal(
      whole.reduce((sum, byte) => times(sum, root) ^ byte, 0),
      0,
    );
});

test("a text beyond the largest size has no code", () => {
  assert.equal(qr("a".repeat(859)), null);
});
