/** Filling the dots of a gel in the browser, against the library. */

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { test } from "node:test";
import { withoutDots } from "../../app/web/site/dots.js";

const SCRIPT = `
import json, sys
import numpy as np
from omnivat.data.dots import fill_dots
for width, height in json.loads(sys.argv[1]):
    pixels = np.frombuffer(sys.stdin.buffer.read(3 * width * height), np.uint8)
    filled, dots = fill_dots(pixels.reshape(height, width, 3))
    print(json.dumps([dots and dots.number, filled.ravel().tolist()]))
`;

/** What the library gives for each of some pictures. */
function library(pictures) {
  const sizes = JSON.stringify(pictures.map(({ width, height }) => [width, height]));
  const options = { input: Buffer.concat(pictures.map(({ pixels }) => pixels)), encoding: "utf-8", maxBuffer: 1e9 };
  return execFileSync("python3", ["-c", SCRIPT, sizes], options)
    .trim()
    .split("\n")
    .map((line) => JSON.parse(line));
}

/** A lit gel with grain; `ink` of (x, y) is the share of light that a dot takes there. */
function gel(width, height, ink, [low, high] = [90, 200]) {
  const pixels = new Uint8ClampedArray(3 * width * height);
  let seed = 7;
  for (let y = 0, at = 0; y < height; y++) {
    for (let x = 0; x < width; x++) {
      for (let c = 0; c < 3; c++, at++) {
        seed = (Math.imul(seed, 1103515245) + 12345) & 0x7fffffff;
        const slope = [x / width, y / height, 1 - x / width][c];
        const share = ink(x, y);
        const lit = low + (high - low) * slope + ((seed >> 16) % 9) - 4;
        pixels[at] = lit * (1 - Math.max(share, 0)) + (235 - lit) * Math.max(-share, 0);
      }
    }
  }
  return { pixels: new Uint8Array(pixels.buffer), width, height };
}
const round =
  (pitch, radius, ink, turn = 0) =>
  (x, y) => {
    const [u, v] = [x + turn * y, y - turn * x].map((w) => ((w % pitch) + pitch) % pitch);
    return Math.hypot(u - pitch / 2, v - pitch / 2) <= radius ? ink : 0;
  };

const CASES = [
  ["dark dots", gel(224, 224, round(27, 4, 0.8)), true],
  ["dots of a turned print", gel(240, 320, round(22, 4, 0.5, 0.05)), true],
  ["light dots", gel(224, 224, round(27, 4.5, -0.8), [30, 60]), true],
  ["dots of a large picture", gel(640, 480, round(55, 9, 0.7)), true],
  ["a gel without dots", gel(224, 224, () => 0), false],
  ["a picture that is too small", gel(40, 60, round(10, 2, 0.8)), false],
];

const WANTED = library(CASES.map(([, picture]) => picture));

for (const [at, [name, picture, dotted]] of CASES.entries()) {
  test(`${name}: the browser gives the bytes of the library`, () => {
    const before = picture.pixels.slice();
    const found = withoutDots(picture);
    const [number, wanted] = WANTED[at];
    assert.equal(number !== null, dotted);
    assert.equal(found !== picture, dotted);
    assert.deepEqual(picture.pixels, before);
    const away = wanted.map((value, at) => Math.abs(value - found.pixels[at]));
    assert.ok(away.every((value) => value <= 1)); // a tie of rounding
    assert.ok(away.filter((value) => value).length <= 0.0005 * away.length);
  });
}
