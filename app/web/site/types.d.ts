/** The records of the page without a server, for `tsc` alone; and see shared/types.d.ts. */

type Floats = Float32Array | Float64Array;
/** An embedding of each image; a missing one is null or left out. */
type Rows = { vis?: Floats | null; tac?: Floats | null };
/** An array of a file or a graph. */
interface Tensor {
  shape: number[];
  values: any;
}
type Tensors = Record<string, Tensor>;
/** Pixels RGB, row by row. */
interface Raster {
  pixels: Uint8Array;
  width: number;
  height: number;
}
/** Mean and variance of each channel over pictures. */
interface Channels {
  mean: Float32Array;
  variance: Float32Array;
  count: number;
}
interface SensorProfile {
  channels: Partial<Record<Modality, Channels>>;
  step?: number;
  domain?: string;
}
/** The name, the hash and the preprocessing of an encoder. */
type Key = Record<"name" | "weights_hash" | "preprocessing", string>;
/** What images are compared with: unit rows, and ascending quantiles of their nearest cosines. */
type KnownImages = Partial<Record<Modality, { rows: Floats[]; quantiles: ArrayLike<number> }>>;
/** What lessons add to a head's prediction: rows (K, 2W), a bias (K,), and the head's share. */
interface LessonMap {
  rows: Floats[];
  bias: number[];
  share: number;
}
/** A head: what models.json has of it, and what lessons made of it. */
interface SiteHead {
  name: string;
  url: URL;
  stages: string;
  parts: Record<string, string>;
  classes: string[];
  learned: number;
  orders: Record<Modality, number>;
  span: [number, number];
  linear: boolean;
  tokens: Partial<Record<Modality, string[]>>;
  training: { index: number[]; of: string };
  parents: number[];
  groups: [start: number, stop: number][];
  arrangement: string;
  in_use: boolean;
  source: string;
  map?: LessonMap;
  known?: KnownImages;
}
/** What a question names; see app/pair_input.py. */
interface Asked {
  before: Rows;
  pair: Rows;
  order: number | null;
  head: SiteHead;
}
/** A question's other parts: the bytes of its file, and whether it was withdrawn. */
interface Sent {
  body: Uint8Array;
  stopped: () => boolean;
}
type Route = (desk: import("./desk.js").Desk, question: any, sent: Sent) => Promise<unknown>;
/** A lesson with its embeddings. */
interface TaughtPair {
  label: string;
  pair: Rows;
}
/** A plane of numbers. */
interface Plane {
  width: number;
  height: number;
  values: Float64Array;
}
interface Spot {
  x: number;
  y: number;
  depth: number;
}
interface Grid {
  nodes: { x: number; y: number }[];
  steps: Point[];
  darkness: number;
}
