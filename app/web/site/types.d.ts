/** The records of the page without a server, for `tsc` alone; and see shared/types.d.ts. */

type Floats = Float32Array | Float64Array;
/** An embedding of each image; a missing one is null or left out. */
type Rows = { vis?: Floats | null; tac?: Floats | null };
/** An array of a file or a graph. */
type Tensor = { shape: number[]; values: any };
type Tensors = Record<string, Tensor>;
/** Pixels RGB, row by row. */
type Raster = { pixels: Uint8Array; width: number; height: number };
/** The numbers and words of models.json (app/site/models.py). */
type SiteRules = { pixels: Record<"jpeg" | "other", number>; side: Record<"least" | "large" | "preview", number> };
/** What models.json has of a head. */
type SiteHead = {
  name: string;
  classes: string[];
  orders: Record<Modality, number>;
  attends: boolean;
  training: { index: number[]; of: string };
  parents: number[];
  groups: [start: number, stop: number][];
  familiarity: string;
  [other: string]: any;
};
/** What a request names; see app/shared/pair_input.py. */
type Resolved = { pair: Rows; order: number | null; head: SiteHead };
/** Whether a question was withdrawn. */
type Sent = { stopped: () => boolean };
type Route = (desk: import("./desk.js").Desk, question: any, sent: Sent) => Promise<unknown>;
