// Rows of tiles that are compressed as the glTF extension EXT_meshopt_compression has them (Khronos,
// 2021, appendix A): vertices in version 0, triangles in version 1, both without a filter.
orbweave.unpack = (function () {
  /// Half of the number, with the sign that its lowest bit tells.
  var signed = function (x) { return (x >>> 1) ^ -(x & 1); };

  /// A group of 16 bytes: all zero, of 2 or 4 bits with what is too large behind them, or as they are.
  function unpackGroup(source, at, mode, group) {
    if (mode === 0) { group.fill(0); return at; }
    if (mode === 3) { group.set(source.subarray(at, at + 16)); return at + 16; }
    var bits = 2 * mode, perByte = 8 / bits, most = (1 << bits) - 1, large = at + 2 * bits;
    for (var i = 0; i < 16; ++i) {
      var value = source[at + Math.floor(i / perByte)] >> (8 - bits - bits * (i % perByte)) & most;
      group[i] = value === most ? source[large++] : value;
    }
    return large;
  }

  /// Blocks of rows. A block has the first byte of all its rows, then the second, as differences.
  function vertices(source, count, stride) {
    if (source[0] !== 0xa0) throw new Error('vertices in a version that is not known');
    var target = new Uint8Array(count * stride), group = new Uint8Array(16), at = 1;
    var last = source.slice(source.length - stride);
    var mostRows = Math.min(Math.floor(8192 / stride) & ~15, 256);
    for (var first = 0; first < count; first += mostRows) {
      var rows = Math.min(mostRows, count - first), groups = Math.ceil(rows / 16);
      for (var byte = 0; byte < stride; ++byte) {
        var modes = at, value = last[byte];
        at += Math.ceil(groups / 4);
        for (var g = 0; g < groups; ++g) {
          at = unpackGroup(source, at, source[modes + (g >> 2)] >> 2 * (g & 3) & 3, group);
          for (var i = 0; i < 16 && 16 * g + i < rows; ++i) {
            value = value + signed(group[i]) & 255;
            target[(first + 16 * g + i) * stride + byte] = value;
          }
        }
        last[byte] = value;
      }
    }
    if (at > source.length) throw new Error('vertices end too early');
    return target;
  }

  /// The last 16 that were put in, the newest first.
  function Recent() { this.all = new Array(16).fill(0); this.next = 0; }
  Recent.prototype.put = function (value) { this.all[this.next & 15] = value; ++this.next; };
  Recent.prototype.get = function (age) { return this.all[this.next - 1 - age & 15]; };

  /// Triangles that share an edge with an earlier one, or begin anew.
  function triangles(source, count) {
    if (source[0] !== 0xe1) throw new Error('triangles in a version that is not known');
    var target = new Uint32Array(count), edges = new Recent(), corners = new Recent();
    var at = 1 + count / 3, table = source.length - 16, next = 0, last = 0;
    var far = function () {
      var value = 0, shift = 0, byte;
      do { byte = source[at++]; value |= (byte & 127) << shift; shift += 7; } while (byte & 128);
      last += signed(value);
      return last;
    };
    /// A corner that is new, recent, or told by its distance.
    var corner = function (code, age, isFar) {
      var v = isFar ? far() : code === 0 ? next++ : corners.get(age);
      return { vertex: v, isPut: isFar || code === 0 };
    };
    for (var t = 0; t < count / 3; ++t) {
      var code = source[1 + t], edge = code >> 4, low = code & 15, a, b, c, third;
      if (edge < 15) {
        a = edges.get(edge)[0]; b = edges.get(edge)[1];
        if (low === 13 || low === 14) { last += low === 13 ? -1 : 1; third = { vertex: last, isPut: true }; } else third = corner(low, low, low === 15);
        c = third.vertex;
        if (third.isPut) corners.put(c);
      } else {
        var both = low < 14 ? source[table + low] : source[at++], second;
        if (low >= 14 && both === 0) next = 0;
        // Corners are new before any is told by its distance.
        a = low === 15 ? -1 : next++;
        second = both >> 4 === 15 && low >= 14 ? null : corner(both >> 4, (both >> 4) - 1, false);
        third = (both & 15) === 15 && low >= 14 ? null : corner(both & 15, (both & 15) - 1, false);
        if (low === 15) a = far();
        second = second || corner(0, 0, true);
        third = third || corner(0, 0, true);
        b = second.vertex; c = third.vertex;
        corners.put(a);
        if (second.isPut) corners.put(b);
        if (third.isPut) corners.put(c);
        edges.put([b, a]);
      }
      edges.put([c, b]); edges.put([a, c]);
      target.set([a, b, c], 3 * t);
    }
    if (at > table) throw new Error('triangles end too early');
    return target;
  }

  return { vertices: vertices, triangles: triangles };
}());
