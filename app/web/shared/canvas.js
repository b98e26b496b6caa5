/** What is drawn on a canvas. */

/** Return the drawing context of a canvas.
 * @param {HTMLCanvasElement | OffscreenCanvas} canvas @param {CanvasRenderingContext2DSettings} options
 * @returns {CanvasRenderingContext2D} */
export function drawingOn(canvas, options = {}) {
  const context = /** @type {CanvasRenderingContext2D | null} */ (canvas.getContext("2d", options));
  if (!context) throw new Error("This browser gives no canvas to draw on.");
  return context;
}

/** Paint a canvas of cells; `colour(x, y)` is [r, g, b], and may have an alpha.
 * @param {HTMLCanvasElement} canvas @param {number} columns @param {number} rows
 * @param {(x: number, y: number) => number[]} colour */
export function paintCells(canvas, columns, rows, colour) {
  [canvas.width, canvas.height] = [columns, rows];
  const image = new ImageData(columns, rows);
  for (let i = 0; i < columns * rows; i++) {
    const [r, g, b, alpha = 255] = colour(i % columns, Math.floor(i / columns));
    image.data.set([r, g, b, alpha], 4 * i);
  }
  drawingOn(canvas).putImageData(image, 0, 0);
}

/** Stroke a path in several widths and colours, the widest first.
 * @param {CanvasRenderingContext2D} context @param {() => void} trace
 * @param {...[width: number, colour: string]} strokes */
export function stroked(context, trace, ...strokes) {
  context.beginPath();
  trace();
  for (const [width, colour] of strokes) {
    context.lineWidth = width;
    context.strokeStyle = colour;
    context.stroke();
  }
}

/** Trace the path of a line. @param {CanvasRenderingContext2D} context @param {Point} from @param {Point} to */
export function segment(context, from, to) {
  context.moveTo(...from);
  context.lineTo(...to);
}
