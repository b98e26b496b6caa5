/** Reducing pictures, against Pillow. */

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { test } from "node:test";
import { reduced } from "../../app/web/site/decode.js";

const SCRIPT = `
import sys, json
from PIL import Image
job = json.load(sys.stdin)
image = Image.new("RGB", (job["width"], job["height"]))
image.putdata([tuple(p) for p in job["rows"]])
image = image.reduce(job["to"])
print(json.dumps([image.size, list(image.tobytes())]))
`;

function picture(width, height) {
  const pixels = new Uint8ClampedArray(3 * width * height);
  let seed = 7;
  for (let i = 0; i < pixels.length; i++) {
    seed = (seed * 1103515245 + 12345) % 2 ** 31;
    pixels[i] = (i / 3) % 5 < 1 ? 255 * (seed % 2) : seed >> 16;
  }
  return { pixels, width, height };
}

function pillow(one, to) {
  const rows = [];
  for (let i = 0; i < one.pixels.length; i += 3) rows.push([...one.pixels.subarray(i, i + 3)]);
  const input = JSON.stringify({ width: one.width, height: one.height, rows, to });
  return JSON.parse(execFileSync("python3", ["-c", SCRIPT], { input, encoding: "utf-8", maxBuffer: 1e9 }));
}

for (const by of [1, 2, 3, 7])
  test(`a picture of 101 × 67 divided by ${by} has every byte of Pillow's`, () => {
    const one = picture(101, 67);
    const found = reduced(one, by);
    const [size, bytes] = pillow(one, by);
    assert.deepEqual([found.width, found.height], size);
    assert.deepEqual([...found.pixels], bytes);
  });
