/** Resizing and reading strips, against Pillow. */

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { test } from "node:test";
import { upright } from "../../app/web/site/decode.js";
import { signalOf } from "../../app/web/site/models.js";
import { FILTERS, reduced, resized, thumbnail } from "../../app/web/site/resize.js";

const SCRIPT = `
import sys, json
from PIL import Image, ImageOps
job = json.load(sys.stdin)
image = Image.new("RGB", (job["width"], job["height"]))
image.putdata([tuple(p) for p in job["rows"]])
what = job["what"]
if what == "reduce": image = image.reduce(job["to"])
elif what == "turn":
    exif = Image.Exif(); exif[274] = job["to"]; image.info["exif"] = exif.tobytes()
    image = ImageOps.exif_transpose(image)
elif what == "strip":
    from omnivat.data.strips import strip_signal
    print(json.dumps(strip_signal(image).tolist()))
    sys.exit()
elif what == "thumbnail": image.thumbnail(job["to"])
else: image = image.resize(job["to"], getattr(Image.Resampling, what.upper()))
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

function pillow(one, what, to) {
  const rows = [];
  for (let i = 0; i < one.pixels.length; i += 3) rows.push([...one.pixels.subarray(i, i + 3)]);
  const input = JSON.stringify({ width: one.width, height: one.height, rows, what, to });
  return JSON.parse(execFileSync("python3", ["-c", SCRIPT], { input, encoding: "utf-8", maxBuffer: 1e9 }));
}

const CASES = [
  [93, 61, "bicubic", [224, 224]],
  [301, 257, "bicubic", [224, 224]],
  [1400, 9, "bicubic", [224, 224]],
  [8, 1000, "bicubic", [224, 224]],
  [224, 300, "bicubic", [224, 224]],
  [301, 257, "box", [64, 1]],
  [101, 67, "reduce", 2],
  [101, 67, "reduce", 3],
  [90, 77, "reduce", 7],
  [500, 333, "thumbnail", [448, 448]],
  [333, 1000, "thumbnail", [100, 100]],
  [1000, 333, "thumbnail", [70, 70]],
  [40, 30, "thumbnail", [448, 448]],
];

for (const [width, height, what, to] of CASES) {
  test(`${what} of ${width} × ${height} gives every byte of Pillow's`, () => {
    const one = picture(width, height);
    const found =
      what === "reduce"
        ? reduced(one, to)
        : what === "thumbnail"
          ? thumbnail(one, to[0])
          : resized(one, ...to, FILTERS[what]);
    const [size, bytes] = pillow(one, what, to);
    assert.deepEqual([found.width, found.height], size);
    assert.deepEqual([...found.pixels], bytes);
  });
}

for (const turn of [1, 2, 3, 4, 5, 6, 7, 8]) {
  test(`a picture of orientation ${turn} is turned as Pillow turns it`, () => {
    const one = picture(7, 4);
    const found = upright(one, turn);
    const [size, bytes] = pillow(one, "turn", turn);
    assert.deepEqual([found.width, found.height], size);
    assert.deepEqual([...found.pixels], bytes);
  });
}

for (const [width, height] of [
  [256, 256],
  [301, 257],
  [64, 1],
  [40, 30],
  [1000, 9],
])
  test(`the signal of a picture of ${width} × ${height} is that of Python`, () => {
    const one = picture(width, height);
    const found = signalOf(one);
    const wanted = pillow(one, "strip");
    assert.equal(found.length, wanted.length);
    found.forEach((value, at) => assert.ok(Math.abs(value - wanted[at]) < 1e-5, `${at}: ${value}, ${wanted[at]}`));
  });
