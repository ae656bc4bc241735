/**
 * View of the map: which part of the system frame lies on the screen, how large, and which way up.
 *
 * The system frame is the plane east-north that touches the Earth at the origin; the page knows metres alone. A view is
 * the point in its middle, the metres that a pixel is wide, and the bearing that points up (0: north; a runway's
 * direction puts that runway upright).
 */

/** Metres a pixel: from a single stand to the whole hemisphere. */
const FINEST = 0.02;
const COARSEST = 40_000;

export class View {
  constructor() {
    /** Size of the map, CSS pixels. */
    this.width = 1;
    this.height = 1;
    /** Middle of the map, metres. */
    this.east = 0;
    this.north = 0;
    /** Metres a pixel. */
    this.scale = 100;
    /** Bearing that points up, radians clockwise from north. */
    this.up = 0;
  }

  /** Matrix from metres to pixels, as canvas has it: x = a e + c n + x0, y = b e + d n + y0. */
  matrix() {
    const cos = Math.cos(this.up) / this.scale;
    const sin = Math.sin(this.up) / this.scale;
    return {
      a: cos,
      b: -sin,
      c: -sin,
      d: -cos,
      x0: this.width / 2 - this.east * cos + this.north * sin,
      y0: this.height / 2 + this.east * sin + this.north * cos,
    };
  }

  /**
   * Pixel at which a point lies.
   * @param {number} east @param {number} north
   * @returns {[number, number]}
   */
  toScreen(east, north) {
    const m = this.matrix();
    return [m.a * east + m.c * north + m.x0, m.b * east + m.d * north + m.y0];
  }

  /** Whether a point lies on the screen. @param {number} east @param {number} north */
  sees(east, north) {
    const [x, y] = this.toScreen(east, north);
    return x >= 0 && y >= 0 && x <= this.width && y <= this.height;
  }

  /**
   * Point that lies at a pixel, metres.
   * @param {number} x @param {number} y
   * @returns {[number, number]}
   */
  toGround(x, y) {
    const right = (x - this.width / 2) * this.scale;
    const ahead = (this.height / 2 - y) * this.scale;
    const cos = Math.cos(this.up);
    const sin = Math.sin(this.up);
    return [this.east + right * cos + ahead * sin, this.north - right * sin + ahead * cos];
  }

  /** Box that holds all that is on the screen: west, south, east, north, metres. */
  bounds() {
    const corners = [
      this.toGround(0, 0),
      this.toGround(this.width, 0),
      this.toGround(0, this.height),
      this.toGround(this.width, this.height),
    ];
    const easts = corners.map((c) => c[0]);
    const norths = corners.map((c) => c[1]);
    return [Math.min(...easts), Math.min(...norths), Math.max(...easts), Math.max(...norths)];
  }

  /**
   * Moves the picture by so many pixels.
   * @param {number} dx @param {number} dy
   */
  pan(dx, dy) {
    const [east, north] = this.toGround(this.width / 2 - dx, this.height / 2 - dy);
    this.east = east;
    this.north = north;
  }

  /**
   * Enlarges by `factor`; what is at the pixel stays there.
   * @param {number} factor @param {number} x @param {number} y
   */
  zoom(factor, x, y) {
    const before = this.toGround(x, y);
    this.scale = Math.min(COARSEST, Math.max(FINEST, this.scale / factor));
    const after = this.toGround(x, y);
    this.east += before[0] - after[0];
    this.north += before[1] - after[1];
  }

  /**
   * Turns the picture about its middle by an angle, radians; positive turns it clockwise.
   * @param {number} angle
   */
  turn(angle) {
    const full = 2 * Math.PI;
    this.up = (((this.up - angle) % full) + full) % full;
  }

  /**
   * Shows a box of metres with a margin.
   * @param {number} west @param {number} south @param {number} east @param {number} north
   */
  show(west, south, east, north) {
    this.east = (west + east) / 2;
    this.north = (south + north) / 2;
    const wide = (east - west) / (this.width * 0.84);
    const high = (north - south) / (this.height * 0.8);
    this.scale = Math.min(COARSEST, Math.max(FINEST, wide, high, 0.5));
  }
}
