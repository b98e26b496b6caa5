/** The zip of a visitor's pictures, read by another program. */

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { crc32, zipped } from "../../app/web/pair/zip.js";

test("the check sum is the one that zip files use", () => {
  assert.equal(crc32(new TextEncoder().encode("123456789")), 0xcbf43926);
});

test("another program reads the files back", () => {
  const files = [
    ["My pairs/wood/0_vis.png", Uint8Array.of(1, 2, 3)],
    ["My pairs/grès/1_tac.png", new Uint8Array(70_000).fill(7)],
    ["empty.txt", new Uint8Array(0)],
  ];
  const file = join(mkdtempSync(join(tmpdir(), "zip-")), "a.zip");
  writeFileSync(file, Buffer.concat(zipped(files).map((part) => Buffer.from(part))));
  const script =
    "import sys, zipfile; z = zipfile.ZipFile(sys.argv[1]); assert z.testzip() is None; " +
    "print([(i.filename, i.file_size) for i in z.infolist()])";
  const said = execFileSync("python3", ["-c", script, file], {
    encoding: "utf-8",
    env: { ...process.env, PYTHONIOENCODING: "utf-8" },
  });
  assert.equal(said.trim(), "[('My pairs/wood/0_vis.png', 3), ('My pairs/grès/1_tac.png', 70000), ('empty.txt', 0)]");
});
