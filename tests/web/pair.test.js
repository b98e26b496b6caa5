/** Try a pair: what it says, without a browser. */

import assert from "node:assert/strict";
import { test } from "node:test";
import "./browser.js";
import { apart, blocksOf, CROPS, restOf } from "../../app/web/pair/feed.js";
import { spread } from "../../app/web/pair/lines.js";
import { recorded } from "../../app/web/pair/live.js";
import { csv } from "../../app/web/pair/many.js";
import { curveHtml } from "../../app/web/pair/own.js";
import { named, paired } from "../../app/web/pair/pairing.js";
import { about } from "../../app/web/pair/rasters.js";
import { atChance, gainOf, readerHtml } from "../../app/web/pair/reader.js";
import { isOwn, keyOf, lessonsFor, missing, mixed, tally, withoutPair, withPair } from "../../app/web/pair/tally.js";
import { cards, classTable, judged, madeOf, sentence, swapHtml } from "../../app/web/pair/verdict.js";
import { aboutP, band } from "../../app/web/pair/what-if.js";
import { changed, told } from "../../app/web/pair/where.js";
import { readerOf, visit } from "../../app/web/shared/api.js";
import { cells } from "../../app/web/shared/csv.js";

const CLASSES = ["wood", "steel"];
const PAIR = {
  classes: CLASSES,
  exact: {
    readings: { fused: [0.9, 0.1], vis: [0.8, 0.2], tac: [0.3, 0.7], vis_branch: [0.9, 0.1], tac_branch: [0.85, 0.15] },
  },
};
const LABELLED = [
  { vis: "image:a", tac: "image:b", label: "wood", said: { fused: "wood", vis: "wood", tac: "steel" } },
  { vis: "image:c", tac: null, label: "steel", said: { vis: "wood" } },
];

test("touch only is the touch with the photo absent, never a branch inside the pair", () => {
  const html = cards(PAIR, { images: {} }, {});
  const touch = html.slice(html.indexOf('data-reading="tac"'));
  assert.match(touch, /steel <b>70/);
  assert.ok(!html.includes("85"));
});

test("an image unlike the training images makes every reading that uses it a guess, without a figure", () => {
  const html = cards(PAIR, { images: { vis: { guess: true }, tac: { guess: false } } }, {});
  const [both, photo, touch] = html.split("<article").slice(1);
  for (const guessed of [both, photo]) {
    assert.match(guessed, /This is a guess/);
    assert.match(guessed, /The photo is unlike anything it has seen/);
    assert.ok(!guessed.includes("%"));
  }
  assert.match(touch, /steel <b>70/);
});

test("with one image there is no reading of both", () => {
  const html = cards({ classes: CLASSES, exact: { readings: { fused: [0.3, 0.7], tac: [0.3, 0.7] } } }, null, {});
  assert.match(html, /Add the photo to see both together/);
  assert.match(html, /No photo here/);
});

test("a prediction is judged by the class of the images that it used", () => {
  assert.match(judged("wood", ["vis"], { vis: "wood", tac: "steel" }, CLASSES), /right/);
  assert.match(judged("wood", ["tac"], { vis: "wood", tac: "steel" }, CLASSES), /it is steel/);
  assert.match(judged("wood", ["vis", "tac"], { vis: "wood", tac: "steel" }, CLASSES), /follows the photo/);
  assert.match(judged("wood", ["vis"], { vis: "cork" }, CLASSES), /a class this head has not learned/);
  assert.equal(judged("wood", ["vis"], {}, CLASSES), "");
});

test("names from files cannot become markup", () => {
  assert.ok(!madeOf({ vis: "<img>", tac: "steel" }).includes("<img>"));
  assert.ok(!classTable(["<b>", "steel"], { fused: [1, 0], vis: [1, 0] }).includes("<b>"));
});

test("familiarity is said in words and as a share of the training images", () => {
  const image = { words: "unlike the training images", quantile: 0.01 };
  assert.equal(sentence("vis", image), "Unlike the training images: 1 of 100 training photos has a farther neighbour.");
  assert.match(sentence("tac", { words: "familiar", quantile: 0.25 }), /^Familiar: 25 of 100/); // an ordinary rank
  assert.match(sentence("vis", { words: "familiar", quantile: 1, cosine: 1 }), /one of the training photos/);
  assert.match(sentence("tac", {}), /has no record/);
});

test("each reading is counted over the pairs that had its images", () => {
  assert.deepEqual(tally(LABELLED), { fused: { right: 1, of: 1 }, vis: { right: 1, of: 2 }, tac: { right: 0, of: 1 } });
});

test("teaching waits for two pairs of each of two classes and names what is there", () => {
  assert.match(missing([]), /none yet/);
  assert.match(missing(LABELLED), /wood 1, steel 1/);
  assert.equal(missing([...LABELLED, ...LABELLED]), "");
});

test("a pair is never predicted from its own label", () => {
  assert.deepEqual(lessonsFor(LABELLED, LABELLED[0]), [{ vis: "image:c", tac: null, label: "steel" }]);
});

test("a pair labelled again keeps its last label", () => {
  const again = withPair(LABELLED, { ...LABELLED[0], label: "steel" });
  assert.equal(again.length, 2);
  assert.equal(again.at(-1).label, "steel");
  assert.equal(withoutPair(again, keyOf(LABELLED[1])).length, 1);
});

test("labels at the ends of lines stay inside the chart and apart", () => {
  for (const ends of [[5, 5, 5], [240, 241, 242, 243], Array.from({ length: 40 }, () => 100)]) {
    const places = spread(ends, 10, 220);
    const sorted = [...places].sort((a, b) => a - b);
    assert.ok(sorted[0] >= 10 - 1e-9 && sorted.at(-1) <= 220 + 1e-9, String(places));
    for (let i = 1; i < sorted.length; i++)
      assert.ok(sorted[i] - sorted[i - 1] >= Math.min(14, 210 / (ends.length - 1)) - 1e-9);
  }
});

test("a pair of two origins is mixed, and no visitor's pair", () => {
  const [own, other, example, row] = ["image:a", "image:b", "example:x/y/z", "row:3"];
  assert.ok(mixed({ vis: own, tac: example }) && mixed({ vis: row, tac: own }) && mixed({ vis: row, tac: example }));
  assert.ok(!mixed({ vis: own, tac: other }) && !mixed({ vis: row, tac: row }) && !mixed({ vis: own, tac: null }));
  assert.ok(isOwn({ vis: own, tac: other }) && isOwn({ vis: null, tac: own }));
  assert.ok(!isOwn({ vis: own, tac: example }) && !isOwn({ vis: null, tac: null }));
});

test("a visitor's photo beside an example's touch is not judged by the example's class", () => {
  assert.equal(judged("wood", ["vis", "tac"], { vis: "", tac: "wood" }, CLASSES), "");
  assert.match(judged("wood", ["tac"], { vis: "", tac: "wood" }, CLASSES), /right/);
});

test("pictures nearer to the other side are asked about only if all of them are", () => {
  assert.match(swapHtml({ vis: { strays: true }, tac: { strays: true } }), /Are these two swapped\?/);
  assert.equal(swapHtml({ vis: { strays: true }, tac: { strays: false } }), "");
  assert.match(swapHtml({ vis: { strays: true } }), /Is this a touch\?/);
  assert.equal(swapHtml({}), "");
});

const FILES = [
  "set/glass/a_vis.png",
  "set/glass/a_tac.jpg",
  "rock/video_frame/rgb_image_000.png",
  "rock/gelsight_frame/touch_image_000.png",
  "set/wood/b_vis.png",
  "notes.txt",
  "holiday.png",
].map((path) => ({ path, file: path }));

test("pictures are paired by their names, and folders named like classes are labels", () => {
  const { pairs, alone } = paired(FILES, "", ["Glass", "wood"]);
  assert.deepEqual(
    pairs.map(({ vis, tac, label }) => [vis, tac, label]),
    [
      ["set/glass/a_vis.png", "set/glass/a_tac.jpg", "Glass"],
      ["rock/video_frame/rgb_image_000.png", "rock/gelsight_frame/touch_image_000.png", ""],
      ["set/wood/b_vis.png", null, "wood"],
    ],
  );
  assert.deepEqual(
    alone.map(({ path }) => path),
    ["holiday.png"],
  );
  assert.equal(named("x/touch_photo_3.png").modality, "vis"); // the last word tells
});

test("a CSV pairs pictures of any name and labels them", () => {
  const table = 'vis,tac,material\r\n"./set/glass/a_vis.png",a_tac.jpg,"cut, glass"\r\nmissing.png,,wood\r\n';
  const { pairs, alone } = paired(FILES, table, []);
  assert.deepEqual(
    pairs.map(({ vis, tac, label }) => [vis, tac, label]),
    [["set/glass/a_vis.png", "set/glass/a_tac.jpg", "cut, glass"]],
  );
  assert.equal(alone.length, 4);
  assert.deepEqual(cells('a,"b ""c"""\n,\n'), [["a", 'b "c"']]);
});

test("a CSV whose paths name one file twice, or a file that another shares its name with, pairs nothing", () => {
  const table = "vis,tac\nvisual/7.png,tactile/7.png\n";
  const [photo, touch] = ["visual", "tactile"].map((folder) => ({ path: `set/${folder}/7.png`, file: folder }));
  assert.deepEqual(paired([photo, touch], table, []).pairs[0].tac, "tactile");
  const bare = { path: "7.png", file: "bare" };
  const once = paired([bare], table, []);
  assert.deepEqual(once.pairs, []);
  assert.match(
    once.problem,
    /'visual\/7.png' and 'tactile\/7.png' of the CSV would be one file, 7.png. Choose the folder/,
  );
  assert.match(paired([bare, bare], table, []).problem, /'visual\/7.png' of the CSV can be 7.png or another file/);
  assert.match(paired([bare], "vis,tac\n7.png,7.png\n", []).problem, /7.png as photo and as touch/);
});

test("the table as CSV marks guesses and holds no formula", () => {
  const rows = [
    {
      name: "=1+1",
      label: "wood",
      classes: CLASSES,
      readings: { fused: [0.9, 0.1], vis: [0.8, 0.2], tac: [0.3, 0.7] },
      images: { vis: { guess: true }, tac: { guess: false } },
    },
    { name: "b", label: "", problem: "'b' is empty, so no." },
  ];
  const [head, first, second] = csv(rows).split("\n");
  assert.match(head, /^pair,label,fused,fused_probability,fused_guess,vis/);
  assert.equal(first, "'=1+1,wood,wood,0.9000,true,wood,0.8000,true,steel,0.7000,false,");
  assert.equal(second, "b,,,,,,,,,,,\"'b' is empty, so no.\"");
});

test("parts that change nothing are not shown", () => {
  const nothing = changed([[0.004, -0.001]]);
  assert.equal(nothing.any, false);
  assert.match(told({ class: "wood", probability: 0.5 }, nothing), /no single part matters/);
  const some = changed([[0.2, 0]]);
  assert.match(
    told({ class: "wood", probability: 0.5 }, some),
    /orange supports <i>wood<\/i>\. Hiding a part changes its probability by at most 20/,
  );
});

test("uniform attention is a sentence", () => {
  assert.match(about(8, 0.001), /Nothing to see: each of the 8 tokens gets the uniform 12\.5 %/);
  assert.match(about(8, 0.2), /Rows attend to columns/);
});

test("the band is what the head was trained for", () => {
  assert.deepEqual(band([0.5, 0.5], [0.496, 0.504]), [0.496, 0.504]); // D = 512, from the frames
  assert.deepEqual(band([0.01, 0.01], [-0.02, 0.04]), [0, 0.04]);
  assert.equal(band([0.5, 0.5], null), null);
  assert.deepEqual(band([0, 1], null), [0, 1]);
  assert.match(aboutP({ learned: 0.5, span: [0.5, 0.5], classes: CLASSES }), /guessing \(50/);
  assert.match(aboutP({ learned: 0.5, span: [0, 1], classes: CLASSES }), /trained for every p/);
  assert.match(aboutP({ learned: 0.5, span: [0.5, 0.5], classes: CLASSES, linear: true }), /no part/);
});

test("a frame unlike the rest picture by more than its noise is a contact", () => {
  const frame = (level, pressed = 0) => {
    const data = new Uint8ClampedArray(4 * 64 * 64).fill(level);
    for (let y = 20; y < 30; y++) data.fill(level + pressed, 4 * (64 * y + 20), 4 * (64 * y + 30));
    return blocksOf({ data, width: 64, height: 64 });
  };
  const rest = restOf([frame(99), frame(100), frame(101)]);
  assert.ok(rest.mean.every((level) => Math.abs(level - 100) < 1e-4));
  assert.ok(apart(frame(103), rest.mean) < rest.limit); // other light is no contact
  assert.ok(apart(frame(100, 20), rest.mean) > rest.limit); // 20 levels on 2 % of the picture are
});

test("crops keep a 4:3 middle or cut the border", () => {
  assert.deepEqual(CROPS["4:3"][1](640, 480), [1, 1]);
  assert.deepEqual(CROPS["4:3"][1](1280, 720), [0.75, 1]);
  assert.deepEqual(CROPS.border[1](100, 100), [0.7, 0.7]);
});

test("a recording is a folder of pairs and a table", async () => {
  const blob = new Blob(["x"]);
  const pictures = [
    ["vis", blob],
    ["tac", blob],
  ];
  const files = await recorded([{ label: "a/b", time: "2026", pictures }]);
  assert.deepEqual(
    files.map(([name]) => name),
    ["recording/My sensor/a_b/0_vis.jpg", "recording/My sensor/a_b/0_tac.jpg", "recording/pairs.csv"],
  );
});

const SHARES = { fused: 0.7, vis: 0.5, tac: 0.6 };
const FACTS = {
  left_out: { 0: SHARES, 20: { ...SHARES, fused: 0.75 } },
  real: {
    pairs: 30,
    always: 10,
    "as they come": { fused: 9, vis: 9, tac: 3 },
    profile: { fused: 13, vis: 15, tac: 5 },
  },
};

test("the curve of labels draws every count, and one count only says what is missing", () => {
  const points = [1, 2, 5].map((objects) => ({ objects, right: 0.1 * objects, low: 0, high: 0.6 }));
  const html = curveHtml({ points, words: "F<1>" });
  assert.match(html, /1: 10\s%, 2: 20\s%, 5: 50\s%/);
  assert.match(html, /5 objects a class/);
  assert.match(html, /F&lt;1&gt;/);
  assert.doesNotMatch(curveHtml({ points: points.slice(0, 1), words: "Label" }), /svg/);
});

test("own pictures are read by the head for them, and nothing else is", () => {
  visit.head = "own";
  assert.equal(readerOf({ vis: "image:a", tac: "image:b" }), "own");
  assert.equal(readerOf({ pairs: [{ vis: "image:a", tac: null }] }), "own");
  assert.equal(readerOf({ vis: "image:a", tac: "row:3" }), "");
  assert.equal(readerOf({ vis: "row:3", tac: "row:3" }), "");
  assert.equal(readerOf({ vis: "row:3", lessons: [{ vis: "image:a", tac: "image:b" }] }), "own"); // it is what was taught
  visit.head = "";
  assert.equal(readerOf({ vis: "image:a" }), "");
});

test("the page says what pictures without labels bring, and where touch is at chance", () => {
  assert.deepEqual(atChance(FACTS), ["tac"]);
  assert.match(gainOf(FACTS), /bring 5\.0 points/);
  const html = readerHtml(FACTS, true, "A");
  assert.match(html, /touch is at chance/);
  assert.match(readerHtml(FACTS, false, "A"), /learned from A alone/);
});
