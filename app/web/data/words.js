/** Longer texts of the page: limits, your own data, glossary. */

/** `signals`: the set has recordings of signals in place of photos and touches. */
export const ABOUT = (simulated, signals) => `<ul>
  ${simulated ? "<li>Simulated data are cleaner and more alike than real ones. Compare stages and heads; do not rely on absolute accuracy.</li>" : ""}
  <li>Most encoders were trained on photos. The distance between touch images and photos depends on the encoder as much as on touch.</li>
  <li>A small gap is not a good head: features that are all alike have no gap and no classes. Look at accuracy and margin beside it.</li>
  ${
    signals
      ? "<li>These are signals: their samples have an order, so p has a meaning. Classes can be told apart near one p only, and a search over p finds it.</li>"
      : "<li>p hardly moves in training, and on the project’s simulated sensors heads trained at any p do about equally well. The order of an encoder’s channels has no physical meaning, so neither has “frequency”.</li>"
  }
  <li>Accuracy is on pairs that the head was not trained on.</li></ul>`;

export const OWN = `<h3>Make them</h3><p>A folder of pairs is <code>&lt;root&gt;/&lt;domain&gt;/&lt;class&gt;/&lt;name&gt;_vis.png</code> and <code>…_tac.png</code>.</p>
<pre tabindex="0">python -m omnivat embed PAIRS --encoder efficientnet-lite0 --out mine.safetensors
python -m omnivat thumbnails PAIRS --embeddings mine.safetensors
python -m omnivat train --embeddings mine.safetensors --source DOMAIN --out my-head
python app.py --head my-head --embeddings mine.safetensors --compare another-head
python -m omnivat export --what page --out lecture.html</pre>
<p>Maps are then computed in the background, eleven stops first, and kept for the next start. Head and embeddings must come from the same encoder. In a notebook: <code>omnivat.notebook.explore("my-head", "mine.safetensors")</code>.</p>`;

const WORDS = [
  ["VIS, TAC", "the photo of a surface, and the image from a camera behind a soft sensor pressed on it"],
  ["Domain", "one sensor and one way of collecting pairs"],
  ["Modality gap", "the distance between the mean directions of VIS and TAC; 0 to 2"],
  ["Domain gap", "the mean distance between the mean directions of two domains"],
  ["Cosine margin", "mean cosine of pairs of the same class minus that of pairs of different classes"],
  [
    "p, fractional order",
    "how far the discrete fractional Fourier transform (DFrFT) turns an embedding into its spectrum: 0 not at all, 1 fully",
  ],
  ["MFFA", "Multimodal Fractional Fourier Adapter: DFrFT, ReLU on real and imaginary part, FrATT"],
  ["FrATT", "attention over the fractional tokens of one modality"],
  ["MMA", "the loss that pulls VIS and TAC towards LANG while training"],
  ["DTG, NOD", "Discrete Tree Generation, and the loss that keeps the nodes of one layer at right angles"],
  [
    "Photo only, touch only",
    "the head uses one image and the other is absent; a branch inside a pair uses both",
  ],
  ["Familiar", "how close an image is to the training images, compared with their distances to one another"],
  ["Pin", "the current pair: Explore marks it and the other tabs show it"],
];
export const glossary = () =>
  `<dl class="words">${WORDS.map(([word, meaning]) => `<dt>${word}</dt><dd>${meaning}</dd>`).join("")}</dl>`;
