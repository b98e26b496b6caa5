/** Try a pair as one object, and what each event makes of it: what changes, the work that follows (in `next`) and the
 * work in hand that stops (in `halt`). work.js does the work and tells its end as another event. No DOM and no request
 * here. */

import { IMAGES, imagesOf, OTHER, READINGS } from "../shared/images.js";

const OWN = "own"; // the server's name of the head for own pictures
const FEWEST = 2; // fewest pairs of a class, and fewest classes, for teaching
const NAMED = 5; // classes in a sentence
const MOST = 500; // pairs of a recording
const APART = 300; // milliseconds between two of them
export const READING = "Reading the image… The first image takes longer, because the encoder is loaded.";

/** What is known of a pair that is not there. */
const NOTHING = { busy: false, answer: null, familiar: null, rivals: null, before: null, journey: null, moving: null };

/** @type {PairTab} */
export const START = {
  facts: {},
  examples: [],
  set: { frames: null, sprite: null },
  heads: [],
  rungs: [],
  real: null,
  source: "its own training pairs",
  tested: null,
  simulated: true,
  head: "",
  vis: null,
  tac: null,
  lost: "",
  away: null,
  take: "both",
  doing: {},
  filming: "",
  explained: {},
  reals: {},
  sent: {},
  touches: [],
  curves: "fused",
  ...NOTHING,
  question: null,
  classes: [],
  on: false,
  frame: null,
  recording: null,
  line: "Use cameras or video files. No picture is kept unless you record.",
  profile: "",
  lit: false,
  counts: null,
  doubt: null,
  mend: "",
  folders: { now: [], before: [] },
  card: null,
  pairs: [],
  taught: false,
  report: null,
  labels: null,
  rows: [],
  unnamed: null,
  notes: { problem: "", own: "", sensor: "", card: "", many: "", live: "" },
};

/** A pair is identified by its two images. @param {Pair} pair */
export const keyOf = ({ vis, tac }) => `${vis ?? ""} ${tac ?? ""}`;

/** True if all images of a pair are the visitor's own. @param {Pair} pair */
export const isOwn = ({ vis, tac }) => {
  const there = [vis || [], tac || []].flat();
  return there.length > 0 && there.every((ref) => ref.startsWith("image:"));
};

/** True if the two images come from different pairs: two of the set, or one and a visitor's. @param {Pair} pair */
export const mixed = ({ vis, tac }) => Boolean(vis && tac) && vis !== tac && !isOwn({ vis, tac });

/** True of a picture that was chosen and that nobody has read yet. @param {Pick<PairTab, "sent">} tab
 * @param {Ref | null | undefined} ref */
const isUnread = ({ sent }, ref) => Boolean(ref && sent[ref] && !sent[ref].width);

/** Touches of this visit, of which lamps can be made. @param {PairTab} tab @param {Ref[]} more */
const touched = ({ touches }, more) => ({ touches: [...new Set([...touches, ...more])] });

/** All but one pair. @param {OwnPair[]} pairs @param {string} key */
const without = (pairs, key) => pairs.filter((one) => keyOf(one) !== key);

/** The label of the open pair; "" if it has none. @param {PairTab} tab */
export const labelOf = (tab) => tab.pairs.find((one) => keyOf(one) === keyOf(tab))?.label ?? "";

/** Correct pairs of each reading, among those that have it; readings that none has are left out.
 * @param {Pick<OwnPair, "label" | "said">[]} pairs */
export const tallies = (pairs) =>
  READINGS.flatMap((reading) => {
    const there = pairs.filter(({ said }) => said[reading]);
    const right = there.filter(({ label, said }) => said[reading] === label).length;
    return there.length ? { reading, right, of: there.length } : [];
  });

/** What is missing before a head can be taught; "" if nothing. @param {{label: string}[]} pairs */
export function missing(pairs) {
  const counts = new Map();
  for (const { label } of pairs) counts.set(label, (counts.get(label) ?? 0) + 1);
  if ([...counts.values()].filter((count) => count >= FEWEST).length >= FEWEST) return "";
  const most = [...counts].sort(([, a], [, b]) => b - a);
  const there = most.slice(0, NAMED).map((count) => count.join(" "));
  if (most.length > NAMED) there.push(`${most.length - NAMED} more classes`);
  return `To teach the head, label two pairs of each of two classes. So far: ${there.join(", ") || "none yet"}.`;
}

/** The lessons of a request about the pair `now`, which is never predicted from its own label.
 * @param {OwnPair[]} pairs @param {Pair} [now] @returns {Lesson[]} */
export const lessonsFor = (pairs, now = {}) =>
  without(pairs, keyOf(now)).map(({ vis, tac, label }) => ({ vis, tac, label }));

/** Those of the taught head; none while the head as trained predicts. @param {PairTab} tab @param {Pair} [now] */
export const lessonsOf = ({ taught, pairs }, now) => {
  const lessons = taught ? lessonsFor(pairs, now) : [];
  return lessons.length ? { lessons } : {};
};

/** A label waits until uploads and predictions are there: it would go to the pair before them. @param {PairTab} tab */
export const isHeld = ({ busy, doing }) => busy || Boolean(doing.fetch) || [doing.vis, doing.tac].includes(READING);

/** Everything about the open pair is requested again. @param {PairTab} tab @param {Partial<PairTab>} change
 * @returns {Change} */
function requested(tab, change = {}) {
  const there = imagesOf({ ...tab, ...change }).length > 0;
  return { away: null, explained: {}, ...(there ? { busy: true } : NOTHING), ...change, next: { predict: {} } };
}

/** Other weights or another profile: request the pair and the table again.
 * @param {PairTab} tab @param {Partial<PairTab>} change @param {Partial<PairWork>} [more] */
const again = (tab, change, more) => ({ ...requested(tab, change), next: { predict: {}, rows: {}, ...more } });

/** Labels changed: discard what was taught from the old ones. @param {PairTab} tab @param {OwnPair[]} pairs
 * @returns {Change} */
function labelled(tab, pairs) {
  const change = { pairs, report: null, labels: null, taught: false, notes: { ...tab.notes, own: "" } };
  return { ...(tab.taught ? again(tab, change) : change), halt: ["curve"] };
}

/** Rows with a label and a prediction. @param {Row[]} rows */
export const labelledOf = (rows) => /** @type {OwnPair[]} */ (rows.filter(({ label, said }) => label && said));

/** The counted pairs and those of the table, each by its last label. @param {Pick<PairTab, "pairs">} tab
 * @param {Row[]} more */
export const joined = ({ pairs }, more) =>
  labelledOf(more).reduce((all, one) => [...without(all, keyOf(one)), one], pairs);

/** Count pairs that have a label and a prediction. @param {PairTab} tab @param {Row[]} more */
const counted = (tab, more) => (labelledOf(more).length ? labelled(tab, joined(tab, more)) : {});

/** No table. @param {PairTab} tab @returns {Change} */
const closed = ({ notes, doing }) => ({
  rows: [],
  unnamed: null,
  notes: { ...notes, many: "" },
  doing: { ...doing, read: undefined },
  halt: ["read", "rows"],
});

/** A recording is saved when it ends. @param {PairTab} tab */
const recorded = ({ recording }) => (recording?.length ? { saveRecording: recording } : {});

/** @type {{[Name in keyof PairEvents]: (tab: PairTab, detail: PairEvents[Name]) => Change}} */
const EVENTS = {
  // what came of some work
  arrived: (tab, parts) => ({ ...parts, next: parts.set && tab.answer ? { predict: {} } : {} }),
  noted: ({ notes }, more) => ({ notes: { ...notes, ...more } }),
  doing: ({ doing }, more) => ({ doing: { ...doing, ...more } }),

  // own pictures: chosen, then read
  held: ({ sent }, more) => ({ sent: { ...more, ...sent } }),
  seen: ({ sent }, more) => {
    const now = Object.entries(more).map(([ref, { width, height, preview }]) => {
      const before = sent[ref];
      return [ref, { ...before, width, height, src: before?.src || preview }];
    });
    return { sent: { ...sent, ...Object.fromEntries(now) } };
  },

  touched,

  // the pair
  again: (tab) => requested(tab),
  opened: (tab, { vis = tab.vis, tac = tab.tac }) => requested(tab, { vis: vis || null, tac: tac || null, lost: "" }),
  // a new picture starts a new pair: nothing of a complete pair, or of an example, stays beside it
  uploaded: (tab, { modality, ref }) => {
    const rest = OTHER[modality];
    const left = tab[rest];
    const goes = left && (tab[modality] || !isOwn({ [rest]: left }));
    const pair = { [modality]: ref, ...(goes && { [rest]: null }) };
    return requested(tab, { ...pair, lost: "", away: goes ? { [rest]: left } : null });
  },
  fetched: (tab, { key, pair }) =>
    requested(tab, { ...pair, lost: "", reals: { ...tab.reals, [key]: pair.tac ?? pair.vis ?? "" } }),
  explained: ({ explained }, parts) => ({ explained: { ...explained, ...parts } }),
  predicted: (tab, found) => ({
    ...NOTHING,
    ...found,
    ...touched(tab, tab.tac && tab.sent[tab.tac] ? [tab.tac] : []),
    classes: found.answer.classes,
    notes: { ...tab.notes, problem: tab.lost },
    next: { compare: {} },
  }),
  // the pair before it stays where a new picture cannot be read
  failed: (tab, problem) => {
    const notes = { ...tab.notes, problem };
    const broken = imagesOf(tab).filter((name) => isUnread(tab, tab[name]));
    if (!broken.length) return { ...NOTHING, notes };
    const without = Object.fromEntries(broken.map((name) => [name, null]));
    const { vis = null, tac = null } = tab.question ?? {};
    const rest = { ...tab, ...without };
    const fresh = imagesOf(rest).some((name) => rest[name] !== tab.question?.[name]);
    if (fresh) return requested(tab, { ...without, lost: problem, notes });
    return { ...(tab.answer ? { busy: false } : NOTHING), vis, tac, away: null, notes };
  },

  // the cameras
  camerasSwitched: (tab) =>
    tab.on
      ? EVENTS.camerasOff(tab, "")
      : {
          on: true,
          line: "Opening the cameras… The first picture takes longer, because the encoder is loaded.",
          notes: { ...tab.notes, problem: "", live: "" },
          next: { live: {} },
        },
  // the pair comes back in their place
  camerasOff: (tab, why) => {
    const { next, ...change } = tab.frame ? requested(tab) : {};
    const off = { on: false, frame: null, recording: null, line: why || tab.line };
    return { ...change, ...off, halt: ["live"], next: { ...next, ...recorded(tab) } };
  },
  framed: ({ recording }, { frame, line, pair }) => {
    const due = recording && pair && recording.length < MOST && pair.time - (recording.at(-1)?.time ?? 0) >= APART;
    return { frame, line, recording: due ? [...recording, pair] : recording };
  },
  recordSwitched: (tab) => ({ recording: tab.recording ? null : [], next: recorded(tab) }),
  guide: ({ doing }, detail) =>
    doing.guide ? {} : { doing: { ...doing, guide: detail.what }, next: { guide: detail } },

  // own pairs
  answered: ({ vis, tac, ...tab }, { label }) =>
    label && isOwn({ vis, tac }) && !isHeld({ vis, tac, ...tab }) ? { next: { count: { vis, tac, label } } } : {},
  counted: (tab, pair) => counted(tab, [pair]),
  forgotten: (tab, { key }) => labelled(tab, without(tab.pairs, key)),
  taught: (tab, report) => again(tab, { report, taught: true, notes: { ...tab.notes, own: "" } }, { curve: {} }),
  used: (tab) => again(tab, { taught: !tab.taught }),
  // own pictures are read by the head for them, or by that of the chapters; what was taught to one is not the other's
  readerSwitched: (tab) => again(tab, { ...labelled({ ...tab, taught: false }, tab.pairs), head: tab.head ? "" : OWN }),

  // many pairs
  dropped: (tab, { files = tab.unnamed?.files ?? [], modality, kind }) =>
    modality && files.length === 1
      ? { next: { upload: { modality, file: files[0].file } } }
      : { ...closed(tab), next: { read: { files, kind } } },
  closed,
  rowsRead: ({ rows }, more) => ({ rows: [...rows, ...more] }),
  // the first pair takes the place of an example
  allRead: (tab) => {
    const first = tab.rows.find(({ said }) => said);
    return first && !isOwn(tab) ? EVENTS.opened(tab, first) : {};
  },
  stopped: ({ rows, notes, doing }) => {
    const many = ` Cancelled after ${rows.length} of ${doing.read?.total} pairs.${notes.many}`;
    return { notes: { ...notes, many }, doing: { ...doing, read: undefined }, halt: ["read"] };
  },
  rowLabelled: (tab, { label: at, value }) => {
    const rows = tab.rows.map((row, i) => (i === +at ? { ...row, label: value.trim() } : row));
    return { ...counted(tab, rows), rows };
  },
  rowsPredicted: ({ rows, notes }, answers) => {
    const answered = new Map(answers.map((row) => [keyOf(row), row]));
    const now = rows.map((row) => ({ ...row, ...answered.get(keyOf(row)), label: row.label }));
    return { rows: now, notes: { ...notes, many: "" } };
  },
  rowsTaught: (tab) => ({ ...counted(tab, tab.rows), next: { teach: {} } }),
  rowsProfiled: ({ rows }) => {
    const [photos, touches] = IMAGES.map((name) => rows.flatMap((row) => row[name] ?? []));
    return { next: { profileOf: { photos, touches } } };
  },

  // my sensor
  // cards of the folders so far
  carded: ({ folders, notes }, { files, side = "now" }) => ({
    folders: { ...folders, [side]: files },
    card: null,
    notes: { ...notes, card: "" },
    next: { card: {} },
  }),
  // the first touch takes the place of an example, so that a remedy shows in its prediction
  cardRead: (tab, { card, tac }) => ({ card, ...(tac && !isOwn(tab) ? EVENTS.opened(tab, { vis: null, tac }) : {}) }),
  // what was made of touches as they came is not one of mended touches
  mended: (tab, { word = "" }) => {
    const words = new Set(tab.mend.split(" ").filter(Boolean));
    if (!words.delete(word) && word) words.add(word);
    const mend = word ? [...words].join(" ") : "";
    return again(tab, { mend, profile: "", lit: false, counts: null, before: null }, { keepProfile: {} });
  },
  sampled: ({ doubt, folders }, { files = doubt?.files ?? folders.now, kind }) => ({
    doubt: null,
    next: { sample: { files, kind } },
  }),
  samplingStopped: ({ notes, doing }) => ({
    notes: { ...notes, sensor: "Cancelled. Nothing was changed." },
    doing: { ...doing, sample: undefined },
    halt: ["sample"],
  }),
  profiled: (tab, { profile, counts, mend = tab.mend, lit = false, note = "" }) => {
    const change = { profile, lit, counts, mend, doubt: null, before: null, notes: { ...tab.notes, sensor: note } };
    return again(tab, change, { keepProfile: {} });
  },
  profileDropped: (tab) => ({ ...EVENTS.profiled(tab, { profile: "", counts: {} }), counts: null }),
};

/** The tab after an event, with the work that follows and stops. What changes nothing by itself is work of that name.
 * @template {keyof PairEvents | keyof PairWork} Name
 * @param {PairTab} tab @param {Name} name @param {(PairEvents & PairWork)[Name]} detail */
export function after(tab, name, detail) {
  const event = /** @type {Record<string, (tab: PairTab, detail: any) => Change>} */ (EVENTS)[name];
  const { next = {}, halt = [], ...change } = event?.(tab, detail) ?? { next: { [name]: detail } };
  return { tab: { ...tab, ...change }, next, halt };
}
