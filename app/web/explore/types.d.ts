/** The records of Explore, for `tsc` alone. */

/** What happened at an element. */
type At = { target: Found };
/** Points or pairs, as a function of their number. */
type Wanted = (index: number) => boolean;
type Span = [low: number, high: number];
/** What pointers and keys on a map do. */
type Pointing = Partial<import("../shared/pointer.js").On>;
/** What is known of a set; null until it has come. */
interface SetFacts {
  unseen: Unseen | null;
  pairs: PairNames | null;
  fit: Fit | null;
}
/** A set that a chapter shows; `own` are the frames of the loaded head itself. */
interface SetData {
  set: string;
  own: Frames;
  sprite: Sprite | null;
  modes: string[];
}
/** A cell of the confusion matrix, with its pairs and its words. */
interface Cell {
  truth: number;
  answer: number;
  pairs: Set<number>;
  words: string;
}
/** Neighbours of a point of the pinned pair, and where they were computed. */
interface Nearest {
  key: string;
  points: { point: number; cosine: number }[];
}
/** Other predictions than those of the first map. */
interface Other {
  name: string;
  frames: Frames;
}
/** The pair of the second chapter: what names it, its row of the set or -1, its journey, or why there is none. */
interface ChosenPair {
  key: string;
  pair: Pair;
  row: number;
  journey: Journey | null;
  note: string;
}
/** The state of Explore beside the address. */
interface Scene extends SetData {
  sets: SetRow[];
  /** the chapter that opens first */
  first: string;
  /** the chapter on screen; "" while its set loads */
  chapter: string;
  facts: SetFacts;
  /** the mode of p that is shown, and the one that is on its way */
  mode: string;
  wanted: string;
  frames: Frames;
  /** the stop of p, and by frames the stops between which p was dragged in the chapter of the order */
  stop: number;
  dragged: Map<Frames, Span>;
  /** how many confidences were there when colours were offered */
  confident: number;
  /** a point; -1 for none */
  hovered: number;
  nearest: Nearest | null;
  /** points */
  selected: Set<number>;
  /** the filter under the pointer */
  highlight: { kind: Filter; name: string } | null;
  cell: Cell | null;
  /** the domain of the confusion matrix */
  stranger: string;
  /** 1 for each point that all filters leave */
  mask: Uint8Array;
  /** the pair that the card shows at first */
  sample: number;
  /** whether a drag on the map selects */
  lasso: boolean;
  /** the measure of the staircase */
  stairs: string;
  /** what predicts on the second map, once loaded */
  other: Other | null;
  /** what each node of the tree predicts over the set; null until it is requested */
  votes: Partial<Replies["votes"]> | null;
  /** the first two chapters: what heads predict of the twins, their places, a point and the only sensor in colour */
  twins: Twins;
  twinsMap: TwinsMap;
  twin: number;
  alone: number;
  /** the place and method that the map of the twins shows or glides to */
  glided: string;
  /** the second chapter: the pair to open with, the chosen one, the stops before this one, and the node of the tree
   * that is pointed at */
  opening: Ref | null;
  chosen: ChosenPair;
  trail: number[];
  node: number;
  /** where the pointer is on the maps, in the window */
  pointer: Point;
  /** what the loaded head reads right on the page's own set, by what is known: a record, or why there is none */
  known: Record<string, Partial<Known> & { problem?: string }>;
}
/** The events of Explore, and what goes with each. */
interface SceneEvents {
  arrived: Partial<Scene>;
  loaded: SetData;
  learned: { set: string; facts: Partial<SetFacts> };
  measured: Scene["known"];
  started: Frames;
  replaced: Frames;
  moved: unknown;
  filtered: unknown;
  cellFollowed: unknown;
  selected: number[];
  lassoSwitched: unknown;
  sensorChosen: number;
}
/** The words of a chapter. */
interface Words {
  title: string;
  figure: Markup;
  remark: Markup;
  whence?: Markup;
}
