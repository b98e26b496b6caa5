/** Try a pair: what it says, without a browser. */

import assert from "node:assert/strict";
import { test } from "node:test";
import "./browser.js";
import { apart, blocksOf, restOf } from "../../app/web/pair/feed.js";
import { spread } from "../../app/web/pair/lines.js";
import { csv, manyHtml } from "../../app/web/pair/many.js";
import { curveHtml, ownHtml } from "../../app/web/pair/own.js";
import { describe } from "../../app/web/pair/own-pictures.js";
import { named, paired } from "../../app/web/pair/pairing.js";
import { cautionOf } from "../../app/web/pair/reader.js";
import { roseHtml } from "../../app/web/pair/sensor.js";
import { after, isOwn, keyOf, lessonsOf, mixed, READING, START, tallies } from "../../app/web/pair/state.js";
import { lineHtml } from "../../app/web/pair/steps.js";
import {
  cards,
  classTable,
  judged,
  liveHtml,
  rivalsHtml,
  sentence,
  spoken,
  swapHtml,
  verdictHtml,
} from "../../app/web/pair/verdict.js";
import { aboutP, band } from "../../app/web/pair/what-if.js";
import { changed, outcome as explained } from "../../app/web/pair/where.js";
import { readerOf, visit } from "../../app/web/shared/api.js";
import { cells } from "../../app/web/shared/csv.js";
import { frames, says } from "./browser.js";

const CLASSES = ["wood", "steel"];
const PAIR = {
  classes: CLASSES,
  learned: 0.5,
  exact: {
    order: 0.5,
    readings: { fused: [0.9, 0.1], vis: [0.8, 0.2], tac: [0.3, 0.7], vis_branch: [0.9, 0.1], tac_branch: [0.85, 0.15] },
  },
  images: {},
};
const STRANGE = { ...PAIR, images: { vis: { guess: true }, tac: { guess: false } } };
const LABELLED = [
  { vis: "image:a", tac: "image:b", label: "wood", name: "a", said: { fused: "wood", vis: "wood", tac: "steel" } },
  { vis: "image:c", tac: null, label: "steel", name: "c", said: { vis: "wood" } },
];
const OWN = { vis: "image:a", tac: "image:b", classes: CLASSES };
/** The tab after some events [name, what goes with it], and the work that the last one asks for. */
const tabAfter = (tab, ...events) =>
  events.reduce((before, [name, what = {}]) => after(before.tab, name, what), { tab: { ...START, ...tab } });

test("touch only is the touch with the photo absent, never a branch inside the pair", () => {
  const html = String(cards(PAIR, {}));
  const touch = html.slice(html.indexOf('data-reading="tac"'));
  assert.match(touch, /steel <b>70/);
  assert.ok(!html.includes("85"));
});

test("an image unlike the training images makes each of its readings a guess without a figure", () => {
  const live = { classes: CLASSES, readings: PAIR.exact.readings, images: STRANGE.images };
  for (const html of [cards(STRANGE, {}), liveHtml(live)].map(String)) {
    const [both, photo, touch] = html.split("<article").slice(1);
    for (const guessed of [both, photo]) {
      assert.match(guessed, /This is a guess.*The photo is unlike all training images/);
      assert.ok(!guessed.includes("%"));
    }
    assert.match(touch, /steel <b>70/);
  }
});

test("the list of classes and the other heads have grey columns and no figures for guesses", () => {
  const html = String(classTable(STRANGE));
  const grey = [...html.matchAll(/<td data-reading="(\w+)" class="of-guess"/g)].map(([, reading]) => reading);
  assert.deepEqual(grey, ["fused", "vis", "fused", "vis"]);
  assert.equal(html.match(/\(guess\)/g).length, 2);
  assert.match(html, /Grey figures belong to a guess/);
  const [, , own, other] = String(rivalsHtml(STRANGE, [{ ...PAIR, label: "other" }])).split("<tr>");
  for (const row of [own, other]) {
    assert.equal(row.match(/wood\?/g).length, 2);
    assert.match(row, /steel <b>70/);
  }
});

test("a figure is read out with the prediction, and of a guess none", () => {
  assert.equal(String(spoken(STRANGE)), "wood? This is a guess.");
  assert.match(String(spoken(PAIR)), /^wood, 90/);
});

test("a prediction is judged by the class of the images that it used; a visitor's picture has none", () => {
  const apart = { vis: "wood", tac: "steel" };
  for (const [used, truths, words] of [
    [["vis"], apart, /correct/],
    [["tac"], apart, /it is steel/],
    [["vis", "tac"], apart, /follows the photo/],
    [["vis"], { vis: "cork" }, /a class that the head does not know/],
    [["vis", "tac"], { vis: "", tac: "wood" }, /^null/],
  ])
    says(judged({ label: "wood", used }, truths, CLASSES), words);
});

test("familiarity is said in words and as a share of the training images", () => {
  const image = { words: "unlike the training images", guess: true, quantile: 0.01 };
  for (const [about, words] of [
    [image, /^Unlike the training photos: only 1 of 100 is more unusual\.$/],
    [{ ...image, quantile: 0 }, /^Unlike the training photos: fewer than 1 of 100 are more unusual\.$/],
    [{ words: "familiar", quantile: 0.08 }, /^Similar to the training photos, but only just: 8 of 100 are/],
    [{}, /has no record/],
  ])
    says(sentence("vis", about), words);
});

test("each reading is counted over the pairs that had its images", () => {
  const counts = tallies(LABELLED).map(({ reading, right, of }) => [reading, right, of]);
  assert.deepEqual(counts, [
    ["fused", 1, 1],
    ["vis", 1, 2],
    ["tac", 0, 1],
  ]);
  assert.deepEqual(tallies([]), []);
});

test("the line names the next step: teaching waits for two pairs of each of two classes", () => {
  for (const [tab, words] of [
    [{}, /<li aria-current="step">Drop/],
    [OWN, /<li aria-current="step">Label.*or make a profile/],
    [{ pairs: LABELLED }, /✓ See<\/li><li aria-current="step">Label.*So far: wood 1, steel 1/],
    [{ pairs: [...LABELLED, ...LABELLED] }, /<li aria-current="step">Teach.*Teach the head your 4 pairs\.</],
  ])
    says(lineHtml({ ...START, ...tab }), words);
});

test("a gain stands as it was measured, and none of another head than the one that reads", () => {
  const measured = { rung: "k3", known: "three labels a class", accuracy: 0.625, from: "this head" };
  const nothing = { rung: "none", known: "nothing", accuracy: 0.5, from: "this head" };
  const line = (more, third = measured) =>
    lineHtml({ ...START, pairs: [...LABELLED, ...LABELLED], rungs: [nothing, third], ...more });
  says(line({}), /On simulated sensors three labels a class raise accuracy by 12\.5 points \(this head\)\./);
  for (const other of [line({ head: "own" }), line({}, { ...measured, from: "records" })])
    assert.doesNotMatch(String(other), /raise/);
});

test("a pair labelled again keeps its last label", () => {
  const again = ["counted", { ...LABELLED[0], label: "steel" }];
  const { pairs } = tabAfter({ pairs: LABELLED }, again).tab;
  assert.equal(pairs.length, 2);
  assert.equal(pairs.at(-1).label, "steel");
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
  const [photo, touch, example, row] = ["image:a", "image:b", "example:x/y/z", "row:3"];
  for (const [vis, tac, ...wanted] of [
    [photo, example, true, false],
    [row, example, true, false],
    [row, row, false, false],
    [photo, touch, false, true],
    [null, touch, false, true],
  ])
    assert.deepEqual([mixed({ vis, tac }), isOwn({ vis, tac })], wanted);
});

test("a picture is called by its pair of the set, by its example or by its file", () => {
  const sent = { "image:f00": { name: "a.png", width: 3, height: 2, credit: "" } };
  const tab = { examples: [{ name: "x/y", class: "wood", domain: "A" }], set: { frames: frames() }, sent };
  for (const [ref, text, truth = ""] of [
    ["image:f00", "a.png · 3\u00a0×\u00a02"],
    ["row:1", "pair 1 · steel · B", "steel"],
    ["row:2", "This set has no pair 2."],
    ["example:x/y", "wood · A", "wood"],
  ]) {
    const said = describe(tab, ref);
    assert.deepEqual([said.text, said.truth ?? ""], [text, truth]);
  }
});

test("pictures nearer to the other side are questioned only if all of them are", () => {
  const [near, far] = [{ strays: false }, { strays: true }];
  for (const [images, words] of [
    [{ vis: far, tac: far }, /Are photo and touch swapped\?/],
    [{ vis: far, tac: near }, /^null/],
    [{ vis: far }, /Is this a touch\?/],
  ])
    says(swapHtml(images, OWN), words);
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
  assert.match(paired([bare], table, []).problem, /would be one file, 7.png/);
  assert.match(paired([bare, bare], table, []).problem, /can be 7.png or another file/);
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
  const nothing = [[0.004, -0.001]];
  assert.equal(changed(nothing).any, false);
  says(explained({ class: "wood", drops: nothing }), /no single part matters/);
  says(explained({ class: "wood", drops: [[0.2, 0]], taught: true }), /Hiding .* by at most 20/);
});

test("the band is what the head was trained for", () => {
  for (const [span, fits, wanted] of [
    [
      [0.5, 0.5],
      [0.496, 0.504],
      [0.496, 0.504],
    ], // D = 512, from the frames
    [[0.5, 0.5], null, null],
    [[0, 1], null, [0, 1]],
  ])
    assert.deepEqual(band(span, fits), wanted);
  for (const [span, linear, words] of [
    [[0.5, 0.5], false, /chance \(50/],
    [[0.5, 0.5], true, /no part/],
  ])
    says(aboutP({ learned: 0.5, span, classes: CLASSES, linear }), words);
});

test("a frame that differs from the no-contact picture by more than its noise is a contact", () => {
  const frame = (level, pressed = 0) => {
    const data = new Uint8ClampedArray(4 * 64 * 64).fill(level);
    for (let y = 20; y < 30; y++) data.fill(level + pressed, 4 * (64 * y + 20), 4 * (64 * y + 30));
    return blocksOf({ data, width: 64, height: 64 });
  };
  const rest = restOf([frame(99), frame(100), frame(101)]);
  assert.ok(rest.mean.every((level) => Math.abs(level - 100) < 1e-4));
  assert.ok(apart(frame(103), rest.mean) < rest.limit); // other light is no contact
  assert.ok(apart(frame(100, 20), rest.mean) > rest.limit); // 20 levels on 2 % of the picture are
  assert.equal(restOf([frame(100), frame(100), frame(100, 20)]), null); // touched meanwhile
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
  const html = String(curveHtml({ points, words: "F<1>" }));
  assert.match(html, /1: 10\s%, 2: 20\s%, 5: 50\s%/);
  assert.doesNotMatch(String(curveHtml({ points: points.slice(0, 1), words: "Label" })), /svg/);
});

test("own pictures are read by the head for them, and nothing else is", () => {
  const [own, row] = [OWN, { vis: "row:3", tac: "row:3" }];
  for (const [head, question, reader] of [
    ["own", own, "own"],
    ["own", { pairs: [{ vis: "image:a", tac: null }] }, "own"],
    ["own", { vis: "image:a", tac: "row:3" }, ""],
    ["own", row, ""],
    ["own", { ...row, lessons: [own] }, "own"], // it is what was taught
    ["", own, ""],
  ]) {
    visit.head = head;
    assert.equal(readerOf(question), reader);
  }
});

test("a reading of own pictures carries what its head read right on real pairs, with or without a profile", () => {
  const tested = { ...FACTS.real, "as they come": { fused: 12, vis: 10, tac: 1 } }; // of the other head
  const tab = { ...START, ...OWN, answer: PAIR, classes: CLASSES, facts: FACTS, tested };
  const card = (more) => String(verdictHtml({ ...tab, ...more })).split('data-reading="tac"')[1];
  assert.match(card({ head: "own" }), /At chance: do not trust this.*correct for 3;.*for 10\./);
  assert.match(card({ head: "" }), /At chance: do not trust this.*correct for 1;/);
  assert.match(card({ head: "own", profile: "x" }), /correct for 5;/);
  assert.match(card({ head: "", tested: null }), /Do not trust this.*never tested on real/);
  for (const more of [{ vis: "row:1", tac: "row:1" }, { taught: true }, { tested: null, simulated: false }])
    assert.doesNotMatch(card(more), /trust/);
  assert.doesNotMatch(String(cautionOf(tab, { reading: "fused", used: ["vis", "tac"], guess: false })), /At chance/);
  assert.equal(cautionOf(tab, { reading: "fused", used: ["vis", "tac"], guess: true }), null);
  const caution = (said) => cautionOf({ ...tab, head: "own" }, said);
  for (const shown of [spoken(PAIR, caution), liveHtml({ ...PAIR, readings: PAIR.exact.readings }, caution)])
    says(shown, /At chance/);
});

const SHOWN = { vis: "row:0", tac: "row:0", answer: PAIR, classes: CLASSES };
const pairOf = ({ vis, tac }) => [vis, tac];

test("other pictures are requested anew, and none leave nothing of the last ones", () => {
  const { tab, next } = tabAfter(SHOWN, ["opened", { vis: "row:1" }]);
  assert.deepEqual([pairOf(tab), tab.busy, next], [["row:1", "row:0"], true, { predict: {} }]);
  const none = tabAfter(SHOWN, ["opened", { vis: "", tac: "" }]).tab;
  assert.deepEqual([none.answer, none.familiar, none.rivals, none.busy], [null, null, null, false]);
});

test("an upload replaces a complete pair, offers to put it back, and joins a picture that waits alone", () => {
  const first = tabAfter(SHOWN, ["uploaded", { modality: "vis", ref: "image:x" }]);
  assert.deepEqual([pairOf(first.tab), first.tab.away], [["image:x", null], { tac: "row:0" }]);
  assert.deepEqual(pairOf(after(first.tab, "uploaded", { modality: "tac", ref: "image:y" }).tab), [
    "image:x",
    "image:y",
  ]);
  const back = after(first.tab, "opened", first.tab.away).tab;
  assert.deepEqual([pairOf(back), back.away], [["image:x", "row:0"], null]);
  assert.ok(mixed(back));
  assert.equal(ownHtml({ ...back, classes: CLASSES }), null); // two pictures of different pairs take no label
});

test("a picture that cannot be read leaves the pair before it, or the other new one", () => {
  const own = { "image:x": { name: "x.png", src: "" }, "image:y": { name: "y.png", src: "", width: 9, height: 9 } };
  const question = { vis: "row:0", tac: "row:0" };
  const bad = tabAfter({ ...SHOWN, question }, ["held", own], ["uploaded", { modality: "vis", ref: "image:x" }]).tab;
  const { tab, next } = after(bad, "failed", "'x.png' is no picture.");
  assert.deepEqual([pairOf(tab), tab.busy, tab.answer, next], [["row:0", "row:0"], false, PAIR, {}]);
  assert.equal(tab.notes.problem, "'x.png' is no picture.");
  const both = after(bad, "uploaded", { modality: "tac", ref: "image:y" }).tab;
  const left = after(both, "failed", "'x.png' is no picture.");
  assert.deepEqual(
    [pairOf(left.tab), left.tab.lost, left.next],
    [[null, "image:y"], "'x.png' is no picture.", { predict: {} }],
  );
  const read = after(both, "seen", { "image:x": { width: 8, height: 8, preview: "data:" } }).tab;
  assert.deepEqual(pairOf(after(read, "failed", "The head is gone.").tab), ["image:x", "image:y"]);
});

test("a label waits until uploads and predictions are there, and goes to no example", () => {
  const label = ["answered", { label: "wood" }];
  assert.deepEqual(tabAfter(OWN, label).next, { count: { vis: "image:a", tac: "image:b", label: "wood" } });
  assert.deepEqual(tabAfter(SHOWN, label).next, {});
  assert.deepEqual(tabAfter(OWN, ["again"], label).next, {});
  const file = new Blob();
  const upload = tabAfter(OWN, ["dropped", { modality: "vis", files: [{ path: "x.png", file }] }]).next;
  assert.deepEqual(upload, { upload: { modality: "vis", file } });
  const sending = tabAfter(OWN, ["doing", { vis: READING }]).tab;
  assert.deepEqual(after(sending, "answered", { label: "wood" }).next, {});
});

test("teaching predicts the pair and the table again, and another label takes it back", () => {
  const report = { judged: [], right: { before: 0, after: 0 }, share: 1 };
  const { tab, next } = tabAfter({ ...OWN, pairs: LABELLED }, ["taught", report]);
  assert.deepEqual(Object.keys(next), ["predict", "rows", "curve"]);
  assert.deepEqual(lessonsOf(tab, OWN), { lessons: [{ vis: "image:c", tac: null, label: "steel" }] }); // not its own
  const fewer = after(tab, "forgotten", { key: keyOf(LABELLED[1]) });
  assert.deepEqual([fewer.tab.taught, fewer.tab.report, Object.keys(fewer.next)], [false, null, ["predict", "rows"]]);
  assert.deepEqual(fewer.halt, ["curve"]);
  assert.deepEqual(lessonsOf(fewer.tab), {});
});

test("own pictures go from one head to the other without what was taught to it", () => {
  const { tab, next } = tabAfter({ ...OWN, head: "own", pairs: LABELLED, taught: true, report: {} }, [
    "readerSwitched",
  ]);
  assert.deepEqual([tab.head, tab.taught, tab.report, tab.pairs.length], ["", false, null, 2]);
  assert.deepEqual(Object.keys(next), ["predict", "rows"]);
});

const row = (name, more = {}) => ({ name, vis: `image:${name}`, tac: null, label: "", ...more });
const READ = [row("a", { readings: { vis: [1, 0] }, said: { vis: "wood" } }), row("b", { vis: null, problem: "No." })];

test("many pairs are read in turn, the first opens in place of an example, and none where reading was stopped", () => {
  const read = { done: 1, total: 3, wait: 0 };
  const note = ["noted", { many: " 1 picture left out." }];
  const begun = [["dropped", { files: [] }], note, ["doing", { read }], ["rowsRead", READ]];
  const { tab, next } = tabAfter(SHOWN, ...begun, ["allRead"]);
  assert.deepEqual([pairOf(tab), tab.rows.length, next], [["image:a", null], 2, { predict: {} }]);
  assert.deepEqual(pairOf(tabAfter(OWN, ...begun, ["allRead"]).tab), pairOf(OWN));
  says(manyHtml(tabAfter(SHOWN, ...begun).tab), /Reading pair 1 of 3/);
  const stopped = tabAfter(SHOWN, ...begun, ["stopped"]);
  says(manyHtml(stopped.tab), / Cancelled after 2 of 3 pairs. 1 picture left out\./);
  assert.deepEqual([pairOf(stopped.tab), stopped.halt], [pairOf(SHOWN), ["read"]]);
});

test("a label of the table is counted at once, and a new prediction keeps labels and what was not read", () => {
  const { tab } = tabAfter({ ...OWN, rows: READ }, ["rowLabelled", { label: "0", value: " wood " }]);
  assert.deepEqual(
    tab.pairs.map(({ name, label, said }) => [name, label, said]),
    [["a", "wood", { vis: "wood" }]],
  );
  const { rows } = after(tab, "rowsPredicted", [row("a", { said: { vis: "steel" } })]).tab;
  assert.deepEqual([rows[0].label, rows[0].said.vis, rows[1].problem], ["wood", "steel", "No."]);
});

test("a profile is kept, followed by the pair and the table, and dropped without a trace", () => {
  const { tab, next } = tabAfter(OWN, ["profiled", { profile: "p", counts: { tac: 6 }, note: "Few." }]);
  assert.deepEqual(
    [tab.profile, tab.notes.sensor, Object.keys(next)],
    ["p", "Few.", ["predict", "rows", "keepProfile"]],
  );
  const gone = after(tab, "profileDropped", {}).tab;
  assert.deepEqual([gone.profile, gone.counts, gone.notes.sensor], ["", null, ""]);
});

test("a second click on a remedy takes it back, and a profile of touches as they came goes with the first", () => {
  const { tab, next } = tabAfter(OWN, ["profiled", { profile: "p", counts: { tac: 6 } }], ["mended", { word: "bgr" }]);
  assert.deepEqual([tab.mend, tab.profile, tab.counts], ["bgr", "", null]);
  assert.deepEqual(Object.keys(next), ["predict", "rows", "keepProfile"]);
  const both = after(tab, "mended", { word: "half-turn" }).tab;
  assert.equal(both.mend, "bgr half-turn");
  assert.equal(after(both, "mended", { word: "bgr" }).tab.mend, "half-turn");
});

test("the first touch of a card takes an example's place, and no own pair's", () => {
  const card = /** @type {any} */ ({ cards: [], changes: null, gels: {} });
  assert.equal(after(START, "cardRead", { card, tac: "image:7" }).tab.tac, "image:7");
  assert.equal(after(OWN, "cardRead", { card, tac: "image:7" }).tab.tac, OWN.tac);
});

test("a lamp is drawn and named on the side from which it lights", () => {
  const rose = String(
    roseHtml([
      [0, 2],
      [-1, 0],
      [1, -1],
    ]),
  );
  assert.match(rose, /red from 90°, green from 0°, blue from 225°/);
  assert.match(rose, /<line x2="0\.0" y2="-34\.0" class="red"/);
});

test("the pair comes back in place of the cameras, once", () => {
  const { tab } = tabAfter(
    SHOWN,
    ["camerasSwitched"],
    ["framed", { frame: { idle: true, readings: {} }, line: "No contact." }],
  );
  says(verdictHtml(tab), /There is no contact/);
  const off = after(tab, "camerasSwitched", {});
  assert.deepEqual([off.tab.on, off.tab.frame, off.next, off.halt], [false, null, { predict: {} }, ["live"]]);
  assert.deepEqual(tabAfter(SHOWN, ["camerasSwitched"], ["camerasOff", "No source."]).next, {});
});

test("a recording takes a pair from time to time, and is saved when it or the cameras end", () => {
  const frame = { idle: false };
  const at = (time) => ["framed", { frame, line: "", pair: { label: "wood", time, pictures: [] } }];
  const begun = [
    ["camerasSwitched"],
    at(1000),
    ["recordSwitched"],
    at(2000),
    at(2100),
    ["framed", { frame, line: "" }],
  ];
  const { tab } = tabAfter(SHOWN, ...begun, at(2300));
  const times = [2000, 2300];
  assert.deepEqual(
    tab.recording.map(({ time }) => time),
    times,
  );
  const full = Array.from({ length: 500 }, () => tab.recording[0]);
  assert.equal(after({ ...tab, recording: full }, ...at(9000)).tab.recording.length, 500);
  for (const end of ["recordSwitched", "camerasSwitched"]) {
    const { tab: ended, next } = after(tab, end, {});
    assert.deepEqual([ended.recording, next.saveRecording.map(({ time }) => time)], [null, times]);
  }
});

test("a second task at the cameras waits for the first", () => {
  const { tab, next } = tabAfter(SHOWN, ["camerasSwitched"], ["guide", { what: "label" }]);
  assert.deepEqual(next, { guide: { what: "label" } });
  assert.deepEqual(after(tab, "guide", { what: "calibrate" }).next, {});
});
