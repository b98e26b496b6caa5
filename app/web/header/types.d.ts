/** The records of the tour, for `tsc` alone: no browser loads this file. */

/** The page's own figures that the tour asks for: what heads predict of the twins, and their map; accuracy over p on
 * the chirps (`curve` at `orders`) and on the sensors (`pale`); what the loaded head predicts in unseen domains. A
 * figure that is missing leaves out the steps that need it. */
interface Figures {
  twins: Twins;
  places: TwinsMap;
  orders: number[];
  curve: number[] | null;
  pale: number[];
  unseen: Pick<Unseen, "look_alikes">;
  gaps: NonNullable<ReturnType<typeof import("../shared/gap-words.js").verdictOn>>;
}
/** A step of the tour; without `ask` it tells only. */
interface TourStep {
  title: string;
  chapter: string;
  /** the figure without which it is left out */
  needs?: "twins" | "places" | "gaps";
  /** what the chapter opens with, and what is shown with the result */
  set?: (at: Figures) => Partial<State>;
  after?: (at: Figures) => Partial<State>;
  ask?: (at: Figures) => Html;
  options?: string[];
  /** places of the options that are right; none if the data cannot decide */
  right?: (at: Figures) => number[];
  reveal: (at: Figures) => Html;
}
