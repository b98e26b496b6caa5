/** The records of the page's scripts, for `tsc` alone: no browser loads this file. Every script sees these names. */

type Modality = "vis" | "tac";
/** What a head reads: both images, or one alone. */
type Reading = "fused" | Modality;
/** A reference to an image: "example:…", "row:…" of the set or "image:…" of the visitor. */
type Ref = string;
/** The images of a pair; a missing one is null or left out. */
type Pair = { vis?: Ref | null; tac?: Ref | null };
/** A labelled pair. */
type Lesson = Pair & { label: string };
type Point = [x: number, y: number];
type Box = [left: number, bottom: number, right: number, top: number];
type Numbers = number[] | Uint8Array | Uint16Array | Int16Array | Float64Array;
type Rgb = [red: number, green: number, blue: number];
type Painter = (context: CanvasRenderingContext2D, cloud: import("./cloud.js").Cloud) => void;

// ---- markup ----

type Html = import("./text.js").Html;
/** Markup, or a text that is escaped where it is written. */
type Markup = Html | string;
/** An element found by its class, as the page's own HTML has it. */
type Found = any;

// ---- what the page offers: tables.json ----

interface Mode {
  id: string;
  can: string[];
  title?: string;
  help?: string;
  file?: string;
  who?: string;
  many?: string;
  away?: string;
  caption?: string;
  note?: string;
  /** why the transform moves points, if it does */
  moving?: string;
  lead?: string;
  words?: string;
}
interface Measure {
  id: string;
  title: string;
  help: string;
  between?: string;
  /** the same for a set of signals */
  signals?: string;
  can?: string[];
}
interface Stage {
  id: string;
  title: string;
  help: string;
  brief: string;
  short: string;
  step: string;
  can?: string[];
  /** the step whose map and gaps it has */
  as?: string;
  /** more help where p changes no distance */
  fixed?: string;
}
interface ColourRow {
  id: string;
  title: string;
  needs?: string[];
  column?: string;
  can?: string[];
}
/** What may be known of a new sensor, as `omnivat/measure/rungs.py` has it. */
interface RungRow {
  id: string;
  words: string;
  brief?: string;
  home?: boolean;
  bar?: string;
  step?: number;
  map?: number;
  title?: string;
  help?: string;
  remark?: string;
}
interface Tables {
  modes: Mode[];
  measures: Measure[];
  stages: Stage[];
  colours: ColourRow[];
  methods: { id: string; title: string }[];
  domains: { id: string; title: string }[];
  rungs: RungRow[];
}

// ---- frames ----

type Frames = import("./frames.js").Frames;
/** What a file of frames says of itself. */
interface FramesMeta {
  orders: number[];
  pairs: number;
  domains: string[];
  classes: string[];
  arrays: Record<string, { dtype: "u8" | "u16"; shape: number[]; offset: number }>;
  maps: Record<
    string,
    { array: string; orders: number[]; bounds: [Point, Point]; max_error: number; trust?: number[] }
  >;
  curves: Record<string, number[]>;
  /** of a head part: arrays in base64, the boxes around each map's VIS and TAC points, and the version of the file */
  inline?: Record<string, string>;
  extents?: Record<string, Box[]>;
  tag?: string;
  embeddings: { encoder: string; origin?: string; simulated?: boolean; weights_hash?: string };
  head?: {
    kind?: string;
    learned_order?: number;
    fits?: [number, number];
    source?: string;
    seeds?: number[];
    width?: number;
  };
}
/** The positions of one map at one stop. */
interface Positions {
  points: Uint16Array | Uint8Array | Float32Array;
  bounds: [Point, Point];
  extents?: Box[];
  drawn?: number;
  stops?: number;
  trust?: number;
  error?: number;
}
/** Points of one colour and shape. */
interface Layer {
  style: Style;
  at: Int32Array;
  count: number;
}
interface Style {
  shape: "circle" | "triangle";
  colour: string;
  radius: number;
  alpha: number;
}
/** What colours and filters read of frames; a run of Train here has it too. */
interface Colourable {
  pairs: number;
  domains: string[];
  classes: string[];
  domain: Numbers;
  label: Numbers;
  kind: string;
  source: string;
  prediction: Numbers;
  confidence: Numbers;
  /** what one image alone predicts for each pair, where that is shown */
  answered: Numbers | null;
  headless: boolean;
  labelled: boolean;
  /** of the table of the pairs */
  columns: Record<string, string[]>;
}
/** A colouring of points: the groups [name, colour], and the group of a pair. */
interface Colouring extends ColourRow {
  /** the group of each pair, if it is the same at every p and of both images */
  values?: (frames: Colourable) => Numbers;
  groups: (frames: Colourable) => [name: string, colour: string][];
  of: (frames: Colourable, stop: number) => (pair: number, tac?: boolean | number) => number;
}
/** The sheet of thumbnails: VIS of pair i is tile i, TAC is tile N + i. */
interface Sprite {
  url: string;
  tile: number;
  columns: number;
  count: number;
}
/** How far long work of the server is. */
interface Step {
  done: number;
  total: number;
  text: string;
}

/** What a page has instead of a server. */
interface Held {
  /** request -> address of a file */
  files: Record<string, string>;
  /** the page's own set */
  home: string;
  sets?: string[];
  /** request -> sentence */
  refused?: Record<string, string>;
  /** the sentence for what needs a server */
  alone: string;
  /** the script of the worker, and the folder of its models; "" where there is none */
  local?: string;
  models?: string;
}

// ---- the state of the page, as the address has it: store.js ----

interface State {
  view: string;
  chapter: string;
  mode: string;
  reading: Reading;
  press: string;
  from: string;
  dots: string;
  known: string;
  alike: string;
  find: string;
  range: string;
  cell: string;
  sel: string;
  rung: string;
  p: number;
  stage: string;
  map: string;
  colour: string;
  domain: string;
  class: string;
  modality: string;
  pin: number | null;
  vis: Ref | null;
  tac: Ref | null;
  /** the head of the second chapter: a mode of p or a head beside the first, of a set */
  by: string;
  p2: number | null;
  stage2: string;
  head2: string;
  beside: string;
  means: string;
  /** beside the address: the values of each chapter when it was left, and p of the tabs that are not open where the
   * chapter of the order is: of the others while Explore is, its own while they are */
  left: Record<string, Partial<State>>;
  otherP: number;
  /** the step of the guided tour; -1 without it */
  tour: number;
}
/** A filter of points. */
type Filter = "domain" | "class" | "modality";

// ---- replies of the server, by route ----

/** A share and its interval. */
interface Share {
  share: number;
  low: number;
  high: number;
}
/** [share, low, high] */
type Interval = [share: number, low: number, high: number];
interface Packed {
  kind: "u1" | "u2" | "i2";
  steps: number;
  data: string;
}
type Answers = Record<`answers/${Reading}` | "retrieval", Share> & { pairs: number };
interface UnseenOf<Values> {
  source: string;
  order: number;
  classes: string[];
  chance: number;
  domains: ({ name: string; is_source: boolean } & Answers)[];
  unseen: Answers;
  look_alikes?: Answers;
  confusion: Record<Reading, Record<string, number[][]>>;
  pairs: { counts: Values; answers: Record<Reading, Values>; confidence: Values; cosine: Values };
}
/** What the head predicts in unseen domains, with the values of each pair. */
type Unseen = UnseenOf<Numbers>;
interface Familiarity {
  cosine: number;
  quantile: number;
  words: string;
  guess: boolean;
}
/** The training pairs nearest to each image; `strays`: an image is nearer to those of the other kind. */
type Near = Partial<Record<Modality, { nearest: { pair: number; cosine: number }[]; strays?: boolean }>>;
type Probabilities = Record<Reading, number[]> & Record<string, number[]>;
interface Prediction {
  readings: Probabilities;
  images: Partial<Record<Modality, Familiarity>>;
}
/** What the head says of a pair at every p. */
interface Predicted {
  classes: string[];
  learned: number;
  span: [number, number];
  linear: boolean;
  touch?: string; // how an own touch is read; "" in colours
  stops: Record<Reading, number[][]>;
  exact: { order: number; readings: Probabilities };
  spectra: Record<Modality, Spectrum>;
  images: Prediction["images"];
}
interface Spectrum {
  rows: number;
  columns: number;
  width: number;
  top: number;
  pixels: string;
}
interface Attention {
  count: Record<Modality, number>;
  off: Record<Modality, string>;
  scale: number;
}
/** A visitor's sensor: the name of its profile, and the pictures in it. */
/** What touches show of their sensor: the server's card, its directions to the right and downwards. */
interface SensorCard {
  pictures: number;
  size: number[];
  lamps: number[][] | null;
  no_lamps: string;
  halves: number | null;
  dots: number;
  pitch: number | null;
  noise: number;
  sharpness: number | null;
  missing: string;
  background: string;
}
interface Profile {
  profile: string;
  mend?: string;
  lit?: boolean; // its lamps read touches
  counts: Partial<Record<Modality, number>>;
  broken?: string[]; // why pictures were left out
}
/** What teaching changed. */
interface Taught {
  judged: { label: string; before: string; after: string }[];
  right: { before: number; after: number };
  share: number;
  classes: string[];
}
interface Labels {
  points: { objects: number; right: number; least: number; most: number }[];
  words: string;
}
/** A head beside the first one; one with a `problem` has only its name and folder. */
interface HeadRow {
  name: string;
  folder: string;
  problem?: string;
  generation?: string;
  mffa?: boolean;
  source?: string;
}
/** A pair at every stop of a head's maps (P): positions in map units, predictions, and the nodes of its tree (N). */
interface Journey {
  orders: number[];
  stops: number[];
  classes: string[];
  learned: number;
  maps: Record<string, { places: Partial<Record<Modality, Point[]>>; nodes: Point[][]; exact: boolean }>;
  readings: Partial<Record<Reading, number[][]>>;
  tree: { parents: number[]; in_use: boolean; probabilities: number[][][]; norms: number[][] };
  images: Prediction["images"];
  own: ({ classes: string[] } & Prediction) | null;
}
interface Tree {
  classes: string[];
  order: number;
  learned: number;
  arrangement: string;
  in_use: boolean;
  parents: number[];
  nodes: { norm: number; probabilities: number[] }[];
  layers: { nodes: number[]; cosines: number[][] }[];
}
/** What is known of a new sensor, and what then is right. */
interface Rung {
  rung: string;
  known: string;
  accuracy: number;
  low: number;
  high: number;
  source: string;
  from: string;
}
interface Known extends Omit<Rung, "from"> {
  pairs: number;
  domains: Record<string, number>;
  draws: number[];
}
/** What is loaded; a part with a `problem` has nothing else. */
interface Facts {
  head: { problem?: string; classes: string[]; source: string; real?: OwnReader["real"] };
  embeddings: { problem?: string; pairs: number; domains: string[]; simulated: boolean };
  sensor: Partial<Profile> & { problem?: string };
}
/** Why the head does not fit the set, and what to do; "" if it fits. */
interface Fit {
  problem: string;
  remedy: string;
  command: string;
}
/** What the head for own pictures reads right: shares on simulated sensors by pictures without labels, pairs on real
 * ones. */
interface OwnReader {
  left_out: Record<string, Record<Reading, number>>;
  real?: { pairs: number; always: number; "as they come": Record<Reading, number>; profile: Record<Reading, number> };
}
interface Choices {
  modes: string[];
  sets: SetRow[];
  twins: boolean;
}
interface SetRow {
  name: string;
  title: string;
  shown: boolean;
  curve: { title: string; orders: number[]; share: number[] } | null;
}
/** Names of the pairs, the classes that they imitate, and the columns that colour points. */
type PairNames = { name: string[]; looks_like: string[]; feels_like: string[] } & Record<string, string[]>;
interface Complex {
  re: number[][];
  im: number[][];
}
interface Toy {
  orders: number[];
  spike: number;
  signals: Record<Modality, Complex>;
  clouds: Record<Modality, Point[][]>;
  distances: Record<"signals" | "clouds", { turned: number[]; clipped: number[] }>;
}
type Input = "touch" | "photo" | "both";
/** What heads predict of the twins. Lists are by source, look (dots as printed, filled; relief), pictures, sensor;
 * `away` is over the other sensors. */
interface Twins {
  simulated: boolean;
  made_by: string;
  head: string;
  classes: string[];
  domains: { name: string; sensor: string; scene: string; about: string }[];
  objects: number;
  pictures: number[];
  known: Record<Input, number[]>;
  lamps: number;
  learned: number[][];
  presses: Record<Input, number[]>;
  accuracy: Record<Input, Interval[][][][]>;
  away: Record<Input, Interval[][][]>;
  shown: { class: number; name: string; press: number; looks_like: string; feels_like: string; sheet: string }[];
  verdicts: Record<Input, string[][][]>;
  split: { head: string; sources: number; loss: Record<Input, Record<string, Interval>[]> };
}
/** Where the twins' touches are: as they come, mean moved, mean and spread moved. */
interface TwinsMap {
  presses: number;
  label: string;
  pca: string[];
  umap: string[];
  own_twin: number[][];
  own_twin_mean: number[];
  gap: number[];
  accuracy: number[];
}
interface Example {
  name: string;
  domain: string;
  class: string;
  simulated: boolean;
}
/** A fetched set of real pairs. */
interface RealSet {
  name: string;
  title: string;
  authors: string;
  terms: string;
  terms_from: string;
  licence: string;
  source: string;
  changes: string;
  count: number;
  pairs: { class: string; pictures: Partial<Record<Modality, string>> }[];
}

interface Replies {
  about: Facts;
  fit: Fit;
  own: Partial<OwnReader>;
  glossary: Record<string, string>;
  heads: HeadRow[];
  modes: Choices;
  first: { ref: Ref | null };
  pairs: PairNames;
  toy: Toy;
  unseen: UnseenOf<Packed>;
  twins: Twins;
  "twins/map": TwinsMap;
  examples: Example[];
  real: { local: boolean; sets: RealSet[]; left_out: string[] };
  "thumbnails.json": Omit<Sprite, "url">;
  pair: Predicted & {
    familiar: Replies["familiar"] | { problem: string };
    journey: Journey | { problem: string };
    moving?: Predicted | { problem: string };
    rivals?: Replies["rivals"];
  };
  many: { classes: string[]; pairs: (Prediction & { problem?: string })[] };
  rivals: Record<string, { problem: string } | Pick<Predicted, "classes" | "exact">>;
  attention: Attention;
  tree: Tree;
  votes: { votes: { class: string; share: number }[]; pairs: number };
  neighbours: { neighbours: { point: number; cosine: number }[] };
  ladder: { rungs: Rung[] };
  known: Known;
  journey: Journey;
  predictions: {
    label: string;
    classes: string[];
    prediction: number[];
    confidence: number[];
    accuracy: Record<string, number>;
  };
  familiar: { images: Near; of: string };
  profile: Profile;
  sensor: Profile;
  teach: Taught;
  curve: Labels;
  taught: { taught: string };
  live: { classes: string[]; ms: { encoder: number; head: number } } & Prediction;
  card: {
    cards: SensorCard[];
    changes: { part: string; evidence: string; cost: string; remedy: string; mend: string; profile: boolean }[] | null;
    gels: Record<string, number[]>; // grain and sharpness of simulated gels
  };
  occlusion: { class: string; probability: number; drops: number[][] };
  part: { part: string };
  load: { set: string };
}
/** The reply to a path: by the route before its question mark. */
type ReplyTo<Path extends string> = Path extends keyof Replies
  ? Replies[Path]
  : Path extends `${infer Route}?${string}`
    ? ReplyTo<Route>
    : unknown;
/** What is sent to a route: a pair or pairs, lessons, and what else it takes. */
type Pictured = Pair & { lessons?: Lesson[]; pairs?: Pair[] };
type Question = Pictured & { [name: string]: unknown };
