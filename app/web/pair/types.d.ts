/** The records of Try a pair, for `tsc` alone: no browser loads this file. */

/** The set, once its map is there. */
type PairSet = { frames: Frames | null; sprite: Sprite | null; later?: Promise<PairSet>; gone?: boolean };
/** The class of each image, if known. */
type Truths = Partial<Record<Modality, string>>;
/** Which images are unlike those that a head learned from. */
type Guesses = Partial<Record<Modality, { guess?: boolean }>> | null;
/** What is predicted of a pair, and how familiar its images are. */
type Answer = Pick<Predicted, "classes" | "exact" | "images">;
/** What one reading of a pair says: a class and its probability, and the images that make it a guess. */
interface Said {
  reading: Reading;
  row: number[];
  label: string; // "" of a reading without its images
  share: number;
  used: Modality[];
  strange: Modality[];
  guess: boolean;
}
/** What another head says of the pair. */
type Rival = { label: string } & Replies["rivals"][string];
/** The prediction of the newest camera pictures; none at rest. */
type Frame = { idle?: boolean; yours?: boolean } & {
  classes: string[];
  readings: Partial<Probabilities>;
  images: Prediction["images"];
};
/** A file and its path in what was chosen. */
interface Chosen {
  path: string;
  file: File;
}
/** A labelled pair of the visitor's, and what each reading of the head predicted for it. */
interface OwnPair extends Pair {
  label: string;
  name: string;
  said: Partial<Record<Reading, string>>;
}
/** A visitor's picture: its name, an address to show it from, who made it if somebody else; and once it was read, its
 * size. */
interface Picture {
  name: string;
  width?: number;
  height?: number;
  src: string;
  credit: string;
}
/** A pair of files, by their names or by a CSV. */
interface FilePair {
  name: string;
  vis: File | null;
  tac: File | null;
  label: string;
}
/** A pair of the table: as it was sent, then as it was predicted; or why it was not. */
interface Row extends Pair {
  name: string;
  label: string;
  classes?: string[];
  readings?: Partial<Probabilities>;
  images?: Prediction["images"];
  said?: OwnPair["said"];
  problem?: string;
}
/** How far some reading is; wait: seconds that are left, 0 while nobody knows. */
interface Progress {
  done: number;
  total: number;
  wait?: number;
}
/** Which parts of an image matter; `taught`: by the taught head. */
type Parts = Replies["occlusion"] & { taught: boolean };
/** Pictures whose names do not tell, and that look like the other kind. */
interface Doubt {
  files: Chosen[];
  strange: number;
  of: number;
}

/** Try a pair as one object. */
interface PairTab {
  facts: Partial<OwnReader>; // of the head for own pictures
  examples: Example[];
  set: PairSet;
  heads: HeadRow[]; // compared with the first one
  rungs: Rung[];
  source: string; // what the head of the chapters was trained on
  tested: OwnReader["real"] | null; // what it read right on real pairs, if measured
  simulated: boolean; // whether the set of the chapters is
  real: Replies["real"] | null;

  vis: Ref | null;
  tac: Ref | null;
  lost: string; // what the address named and could not be had, until another pair is chosen
  away: Pair | null; // the image that a new picture took away
  take: "both" | Modality; // of an example
  // work in hand
  doing: { [work in Modality | "fetch" | "guide" | "card"]?: string } & { read?: Progress; sample?: Progress };
  filming: Modality | "";
  explained: Partial<Record<Modality, Parts>>;
  reals: Record<string, Ref>; // real pairs that were sent
  sent: Record<Ref, Picture>; // own pictures
  touches: Ref[]; // those that are touches
  curves: Reading; // whose curves against p are shown

  busy: boolean; // a prediction is on its way
  answer: Predicted | null;
  question: Question | null; // of the answer
  classes: string[]; // of the head that answered last
  familiar: Replies["familiar"] | { problem: string } | null;
  rivals: Rival[] | null;
  journey: Journey | null; // by the head of the chapters, at every stop of p
  // what follows p: of that head where linear maps have predicted
  moving: { answer: Predicted; question: Question } | null;
  on: boolean; // whether the cameras are
  frame: Frame | null; // what the cameras show
  line: string; // below the cameras
  recording: Recorded[] | null;

  head: string; // what reads own pictures; "": the head of the chapters
  profile: string;
  lit: boolean; // whether touches are read by its lamps
  counts: Profile["counts"] | null; // pictures in the profile
  mend: string; // how own touches are mended before they are read, in words of MENDS
  folders: Record<"now" | "before", Chosen[]>; // of the sensor's card
  card: Replies["card"] | null;
  doubt: Doubt | null;
  before: (Prediction & { classes: string[] }) | null; // the open pair without the profile

  pairs: OwnPair[];
  taught: boolean; // whether the taught head predicts
  report: Taught | null;
  labels: Labels | null; // what fewer labels of each class teach
  rows: Row[]; // of many pairs
  unnamed: { files: Chosen[]; count: number } | null; // files whose names do not tell photo from touch
  notes: { problem: string; own: string; sensor: string; card: string; many: string; live: string };
}
/** The events of the tab, and what goes with each. */
interface PairEvents {
  arrived: Partial<PairTab>;
  noted: Partial<PairTab["notes"]>;
  doing: PairTab["doing"];
  held: PairTab["sent"];
  seen: Record<Ref, { width: number; height: number; preview: string }>;
  touched: Ref[];
  again: unknown;
  opened: Pair;
  uploaded: { modality: Modality; ref: Ref };
  fetched: { key: string; pair: Pair };
  explained: PairTab["explained"];
  predicted: Partial<Pick<PairTab, "familiar" | "rivals" | "journey" | "moving">> & {
    answer: Predicted;
    question: Question;
  };
  failed: string;
  camerasSwitched: unknown;
  camerasOff: string;
  framed: { frame: Frame; line: string; pair?: Recorded };
  recordSwitched: unknown;
  guide: { what: string };
  answered: { label: string };
  counted: OwnPair;
  forgotten: { key: string };
  taught: Taught;
  used: unknown;
  readerSwitched: unknown;
  dropped: { files?: Chosen[]; modality?: Modality; kind?: Modality };
  closed: unknown;
  rowsRead: Row[];
  allRead: unknown;
  stopped: unknown;
  rowLabelled: { label: string; value: string };
  rowsPredicted: Row[];
  rowsTaught: unknown;
  rowsProfiled: unknown;
  carded: { files: Chosen[]; side?: string };
  cardRead: { card: Replies["card"]; tac: Ref | null };
  mended: { word?: string };
  sampled: { files?: Chosen[]; kind?: Modality };
  samplingStopped: unknown;
  profiled: Profile & { note?: string };
  profileDropped: unknown;
}
/** The work that the tab asks for, and what goes with it. */
interface PairWork {
  predict: unknown;
  pin: { pair: string };
  everyP: unknown;
  compare: unknown;
  upload: { modality: Modality; file: File };
  live: unknown;
  guide: { what: string };
  saveRecording: Recorded[];
  photograph: { modality: Modality };
  explain: { modality: Modality };
  fetch: { key: string };
  count: Pair & { label: string };
  teach: unknown;
  curve: unknown;
  save: { path: string; name: string };
  savePictures: unknown;
  csv: unknown;
  read: { files: Chosen[]; kind?: Modality };
  rows: unknown;
  profileOf: { photos: Ref[]; touches: Ref[] };
  card: unknown;
  sample: { files: Chosen[]; kind?: Modality };
  load: { files: { file: Blob }[] };
  keepProfile: unknown;
  saveProfile: unknown;
}
/** What an event makes of the tab: what changes, the work that follows, and work in hand that stops. */
type Change = Partial<PairTab> & { next?: Partial<PairWork>; halt?: (keyof PairWork)[] };
/** What work is given: the tab as it is when it begins, and how to tell an event. */
interface Desk {
  tab: PairTab;
  send: <Name extends keyof PairEvents | keyof PairWork>(name: Name, detail: (PairEvents & PairWork)[Name]) => unknown;
  box: HTMLElement;
  feeds: import("./feed.js").Feed[];
  map: ((journey: Journey | null, problem?: string) => void) | null;
}
interface Recorded {
  label: string;
  time: number;
  pictures: (readonly [Modality, Blob, readonly [width: number, height: number]])[];
}
type Attended = Attention;
/** A rest picture: the grey level of each block, and the change beyond which a picture is a contact. */
interface Rest {
  shape: string;
  mean: Float32Array;
  limit: number;
}
/** Probabilities (P, K) at P orders from 0 to 1, one of them marked; band: what the head was trained for. */
interface Curves {
  classes: string[];
  p: number;
  rows: number[][];
  learned: number;
  band: [number, number] | null;
}
/** Once the relief was opened: plotly.js. */
interface Window {
  Plotly: any;
}
