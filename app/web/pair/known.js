/** A text for an image reference, and its class if the set has one. */

import { NO_CLASS } from "../shared/text.js";
import { sent } from "./sent.js";

export class Known {
  constructor(examples, { frames }) {
    this.examples = examples;
    this.frames = frames;
  }

  /** {text, truth}; truth is undefined for uploaded images. */
  of(ref) {
    const at = ref.indexOf(":");
    const [kind, name] = [ref.slice(0, at), ref.slice(at + 1)];
    if (kind === "example") {
      const example = this.examples.find((one) => one.name === name);
      return { text: example ? `${example.class} · ${example.domain}` : name, truth: example?.class };
    }
    const { frames } = this;
    if (kind === "row" && frames && +name < frames.pairs) {
      const truth = frames.classes[frames.label[+name]];
      if (truth === NO_CLASS) return { text: `pair ${name} · ${frames.domains[frames.domain[+name]]}` };
      return { text: `pair ${name} · ${truth} · ${frames.domains[frames.domain[+name]]}`, truth };
    }
    if (kind === "row") return { text: `pair ${name}` };
    const image = sent.get(ref);
    return { text: image ? `${image.name} · ${image.width} × ${image.height}` : ref };
  }

  /** A short name for a pair of the visitor's. */
  name({ vis, tac }) {
    const names = [vis, tac].filter(Boolean).map((ref) => sent.get(ref)?.name ?? this.of(ref).text);
    return [...new Set(names)].join(" + ");
  }
}
