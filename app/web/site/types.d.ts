/** The records of the page without a server, for `tsc` alone; and see shared/types.d.ts. */

type Floats = Float32Array | Float64Array;
/** An embedding of each image; a missing one is null or left out. */
type Rows = { vis?: Floats | null; tac?: Floats | null };
/** An array of a file or a graph. */
type Tensor = { shape: number[]; values: any };
type Tensors = Record<string, Tensor>;
/** Pixels RGB, row by row. */
type Raster = { pixels: Uint8Array; width: number; height: number };
/** Mean and variance of each channel over pictures. */
type Channels = { mean: Floats; variance: Floats; count: number };
type SensorProfile = { channels: Partial<Record<Modality, Channels>>; step?: number; domain?: string };
/** Of an encoder. */
type Key = Record<"name" | "weights_hash" | "preprocessing", string>;
/** What images are compared with: rows, and ascending quantiles of their nearest cosines. */
type KnownImages = Partial<Record<Modality, Tensor[]>>;
/** A head: what models.json has of it (app/site_models.py), and what lessons made of it. */
type SiteHead = {
  name: string;
  classes: string[];
  orders: Record<Modality, number>;
  attends: boolean;
  training: { index: number[]; of: string };
  parents: number[];
  groups: [start: number, stop: number][];
  map?: Tensor[];
  known?: KnownImages;
  [other: string]: any;
};
/** What a question names; see app/pair_input.py. */
type Asked = { before: Rows; pair: Rows; order: number | null; head: SiteHead };
/** A question's other parts: the bytes of its file, and whether it was withdrawn. */
type Sent = { body: Uint8Array; stopped: () => boolean };
type Route = (desk: import("./desk.js").Desk, question: any, sent: Sent) => Promise<unknown>;
