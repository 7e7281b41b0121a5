// Signals of one run as they come: one growing column for each row of the binary frame.

const FIRST_ROOM = 4096;

/** Columns by name, all of the same `count`. */
export class Signals {
  constructor(run = null) {
    this.run = run;
    this.count = 0;
    this.room = 0;
    this.columns = {};
  }

  /** Append `count` values of each row; rows stand one after the other from `start` in `buffer`. */
  append(rows, count, buffer, start) {
    this.reserve(rows, this.count + count);
    rows.forEach((name, index) => {
      const values = new Float32Array(buffer, start + 4 * index * count, count);
      this.columns[name].set(values, this.count);
    });
    this.count += count;
  }

  reserve(rows, wanted) {
    if (wanted <= this.room && rows.every((name) => this.columns[name])) return;
    this.room = Math.max(FIRST_ROOM, 2 ** Math.ceil(Math.log2(wanted)));
    for (const name of rows) {
      const grown = new Float64Array(this.room);
      const old = this.columns[name];
      if (old) grown.set(old.subarray(0, this.count));
      this.columns[name] = grown;
    }
  }

  /** A column as far as it is filled. */
  column(name) {
    const column = this.columns[name];
    return column ? column.subarray(0, this.count) : new Float64Array(0);
  }

  /** Middle of least and most at the newest moment; null when nothing of it has come. */
  newest(name) {
    if (!this.count || !this.columns[`${name}_least`]) return null;
    const at = this.count - 1;
    return 0.5 * (this.columns[`${name}_least`][at] + this.columns[`${name}_most`][at]);
  }

  /** run_s of the newest moment; null when nothing has come. */
  newestTime() {
    return this.count ? this.columns.run_s[this.count - 1] : null;
  }
}
