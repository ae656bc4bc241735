/** Plots of values over time, and histograms, on small canvases. */

/** @typedef {{name: string, colour: string, times: number[], values: number[]}} Series */

/**
 * Paints series over one time axis that ends at `until`.
 * @param {HTMLCanvasElement} canvas @param {Series[]} series
 * @param {{since: number, until: number, unit: string, end: string, text: string, line: string, low?: number, high?: number,
 *   least?: number, bands?: [number, string][]}} options
 *   `end`: what the end of the time axis is called; `least`: smallest range of values that is shown; `bands`: values with a name at which a line is drawn.
 */
export function plot(canvas, series, options) {
  const ctx = prepared(canvas);
  if (!ctx) return;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  let low = options.low ?? Infinity;
  let high = options.high ?? -Infinity;
  for (const { times, values } of series)
    values.forEach((value, k) => {
      if (!Number.isFinite(value) || times[k] < options.since) return;
      if (options.low === undefined) low = Math.min(low, value);
      if (options.high === undefined) high = Math.max(high, value);
    });
  if (!(low <= high)) [low, high] = [0, 1];
  const least = options.least ?? 1e-9;
  if (high - low < least) {
    const middle = (low + high) / 2;
    const half = Math.max(1, least / 2);
    [low, high] = [middle - half, middle + half];
  }
  const left = 44;
  const bottom = height - 14;
  const x = (/** @type {number} */ t) =>
    left + ((t - options.since) / Math.max(1e-9, options.until - options.since)) * (width - left - 4);
  const y = (/** @type {number} */ v) => bottom - ((v - low) / (high - low)) * (bottom - 6);
  ctx.font = "10px system-ui, 'DejaVu Sans', sans-serif";
  ctx.strokeStyle = options.line;
  ctx.lineWidth = 1;
  ctx.beginPath();
  for (const value of [low, (low + high) / 2, high]) {
    ctx.moveTo(left, Math.round(y(value)) + 0.5);
    ctx.lineTo(width - 4, Math.round(y(value)) + 0.5);
  }
  ctx.stroke();
  ctx.fillStyle = options.text;
  ctx.textAlign = "right";
  for (const value of [low, high]) ctx.fillText(short(value, high - low), left - 4, y(value) + 4);
  ctx.fillText(options.unit, left - 4, y((low + high) / 2) + 4);
  ctx.fillText(options.end, width - 4, height - 2);
  ctx.textAlign = "left";
  ctx.fillText(`−${Math.round(options.until - options.since)} s`, left, height - 2);
  ctx.setLineDash([3, 3]);
  for (const [value, name] of options.bands ?? []) {
    if (value < low || value > high) continue;
    ctx.beginPath();
    ctx.moveTo(left, y(value));
    ctx.lineTo(width - 4, y(value));
    ctx.stroke();
    ctx.fillText(name, left + 3, y(value) - 2);
  }
  ctx.setLineDash([]);
  ctx.lineWidth = 1.4;
  let nameX = left + 6;
  for (const { name, colour, times, values } of series) {
    ctx.strokeStyle = ctx.fillStyle = colour;
    ctx.beginPath();
    let pen = false;
    for (let k = 0; k < times.length; k++) {
      if (times[k] < options.since || !Number.isFinite(values[k])) {
        pen = false;
        continue;
      }
      if (pen) ctx.lineTo(x(times[k]), y(values[k]));
      else ctx.moveTo(x(times[k]), y(values[k]));
      pen = true;
    }
    ctx.stroke();
    if (series.length > 1) {
      ctx.fillText(name, nameX, 11);
      nameX += ctx.measureText(name).width + 9;
    }
  }
}

/**
 * Paints a histogram of latencies on a logarithmic axis, 1 microsecond to 10 seconds.
 * @param {HTMLCanvasElement} canvas
 * @param {[number, number][]} buckets Upper edge in microseconds, and count, rising.
 * @param {{bar: string, text: string, line: string}} colours
 */
export function histogram(canvas, buckets, colours) {
  const ctx = prepared(canvas);
  if (!ctx) return;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  const bottom = height - 13;
  const bins = new Float64Array(56);
  for (const [micros, count] of buckets) {
    const bin = Math.floor((Math.log10(Math.max(1, micros)) / 7) * bins.length);
    bins[Math.min(bins.length - 1, bin)] += count;
  }
  const most = Math.max(1, ...bins);
  ctx.fillStyle = colours.bar;
  const step = width / bins.length;
  bins.forEach((count, k) => {
    // Logarithmic as well: the tail matters more than the mass.
    const tall = count > 0 ? ((bottom - 2) * Math.log1p(count)) / Math.log1p(most) : 0;
    ctx.fillRect(k * step, bottom - tall, step - 1, tall);
  });
  ctx.fillStyle = colours.text;
  ctx.font = "10px system-ui, 'DejaVu Sans', sans-serif";
  ["1 µs", "", "100 µs", "", "10 ms", "", "1 s"].forEach((text, k) => ctx.fillText(text, (k / 7) * width, height - 2));
  ctx.strokeStyle = colours.line;
  ctx.strokeRect(0.5, bottom + 0.5, width - 1, 0);
}

/** @param {HTMLCanvasElement} canvas */
function prepared(canvas) {
  const size = Number(document.body.style.getPropertyValue("zoom")) || 1;
  const ratio = (window.devicePixelRatio || 1) * size;
  const [width, height] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const ctx = canvas.getContext("2d");
  if (!ctx || width === 0) return null;
  ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
  ctx.clearRect(0, 0, canvas.clientWidth, canvas.clientHeight);
  return ctx;
}

/** Value of an axis, as exactly as the axis needs it. @param {number} value @param {number} range */
function short(value, range) {
  return value.toFixed(range >= 20 ? 0 : range >= 2 ? 1 : 2);
}
