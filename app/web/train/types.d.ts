/** The records of Train here, for `tsc` alone: no browser loads this file. */

/** A training of the visitor's. */
interface Run {
  started: Started;
  question: Settings;
  epochs: Epoch[];
  standing: Standing;
}
/** What the browser keeps of the last training. */
interface KeptRun {
  started: Started;
  question: Settings;
  /** without their maps, once it is done */
  epochs?: Epoch[];
}
/** What the charts show before a run: the visitor's last one, or how the loaded head was trained. */
interface Before {
  title: string;
  epochs: Epoch[];
  classes: number;
  question?: Settings;
}
interface TrainState {
  run: Run | null;
  before: Before | null;
  /** the epoch shown, and whether it is the newest one */
  at: number;
  follows: boolean;
  /** runs of this visit that are done */
  earlier: Run[];
  /** from a press of Train to the end of its run */
  busy: boolean;
  problem: string;
}
type TrainEvent =
  | { kind: "asked" }
  | { kind: "refused"; problem: string }
  | { kind: "started"; started: Started; question: Settings }
  | { kind: "news"; run: string; reply: Replies["training"] }
  | { kind: "looked"; at: number };
