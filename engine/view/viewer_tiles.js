// Tiles of 3D Tiles 1.1 as "orbweave tileset" writes them, for viewer.js: loaded where they are
// looked at, as fine as the picture shows, within a limit of memory.
(function () {
  var byId = orbweave.byId, sub = orbweave.sub, dot = orbweave.dot;
  var meta = JSON.parse(byId('meta').textContent);
  var asked = new URLSearchParams(location.search);
  var number = function (key, otherwise) { return Number(asked.get(key)) > 0 ? Number(asked.get(key)) : otherwise; };
  var mostPixels = number('error', 1.5);                // of a tile's error, on the screen
  var mostBytes = number('memory', 1024) * 1048576;     // of all tiles that are loaded
  var mostRequests = 6;
  var note = function (name, value) { document.documentElement.setAttribute('data-' + name, String(value)); };
  var complain = function (what) { byId('tape').textContent = what; note('trouble', what); };
  var count = function (n) { return n.toLocaleString('en'); };

  if (location.protocol === 'file:') {
    complain('A page that is opened from a file can load no tiles. Serve this folder: orbweave view . --serve');
    return;
  }
  var get = function (name) {
    return fetch(name).then(function (answer) {
      if (!answer.ok) throw new Error(name + ': status ' + answer.status);
      return answer;
    });
  };
  get('tileset.json').then(function (answer) { return answer.json(); }).then(begin).catch(function (e) { complain(String(e)); });

  function begin(tileset) {
    var box = tileset.root.boundingVolume.box, middle = box.slice(0, 3), extent = [2 * box[3], 2 * box[7], 2 * box[11]];
    var size = Math.max(extent[0], extent[1], extent[2]) || 1;
    var toDrawing = function (p) { return sub(p, middle).map(function (x) { return x * 2 / size; }); };
    var all = { tiles: 0, triangles: 0, levels: tileset.root.extras.level + 1 };
    /// Boxes and errors in drawing coordinates; what a tile takes is guessed until it is there.
    function tileOf(json) {
      var b = json.boundingVolume.box, half = [b[3], b[7], b[11]].map(function (x) { return x * 2 / size; });
      var children = (json.children || []).map(tileOf);
      ++all.tiles;
      if (children.length === 0) all.triangles += json.extras.triangles;
      return { uri: json.content.uri, error: json.geometricError * 2 / size, level: json.extras.level, children: children, middle: toDrawing(b.slice(0, 3)),
        half: half, radius: Math.hypot(half[0], half[1], half[2]), bytes: 80 * json.extras.triangles, part: null, state: 'absent', used: 0 };
    }
    var root = tileOf(tileset.root);

    // Without a turn but between axes the transform leads to the mesh's own coordinates.
    var m = tileset.root.transform, column = function (i) { return m.slice(4 * i, 4 * i + 3); };
    var isLocal = [0, 1, 2].every(function (i) { return column(i).every(function (x) { return x === 0 || Math.abs(x) === 1; }); });
    var origin = [0, 1, 2].map(function (i) { return dot(column(i), m.slice(12, 15)); });
    var upright = isLocal ? [0, 1, 2].filter(function (i) { return column(i)[2] === 1; })[0] : 2;

    // What tiles say of faces.
    var extras = tileset.extras || {}, holes = extras.holes || [], ofFaces = [];
    if (holes.length > 0) ofFaces = orbweave.patchModes.slice(0, 'confidence' in holes[0] ? 2 : 1);
    if (extras.components > 1) ofFaces.push(['components', 'components']);
    // What vertices tell of their points.
    var ranges = {};
    (extras.vertex_values || []).forEach(function (range) { ranges[range.name] = range; });
    function paintOfValue(part, name) {
      var values = part.values[name], low = ranges[name].low, width = ranges[name].high - low || 1;
      return orbweave.valuePaint(name, values.length, function (v) { return values[v] < 0 ? -1 : Math.max(0, (values[v] - low) / width); }, plainColor);
    }
    var bytesOf = function (color) { return color.map(function (x) { return Math.round(255 * x); }); };
    /// Null where faces of the part say nothing, so that it is plain.
    function paintOfFaces(part, mode) {
      var tags = mode === 'components' ? part.component : mode === 'patches' || mode === 'confidence' ? part.hole : null;
      if (!tags) return null;
      var plain = bytesOf(plainColor), paint = new Uint8Array(3 * tags.length);
      for (var v = 0; v < tags.length; ++v)
        paint.set(mode === 'components' ? orbweave.hue(tags[v]) : tags[v] === 0 ? plain : bytesOf(orbweave.patchColor(mode, part.confidence ? part.confidence[v] : 1)), 3 * v);
      return paint;
    }
    var plainColor = [0.86, 0.82, 0.74];

    var facts = [count(all.triangles) + ' triangles', count(all.tiles) + ' tiles of ' + all.levels + ' levels'];
    if (extras.components > 1) facts.push(count(extras.components) + ' components');
    var viewer = orbweave.makeViewer({
      name: meta.name, facts: facts, up: upright, extent: extent, size: size,
      colors: [['points', 'of the points']].concat(ofFaces, orbweave.valueModes(Object.keys(ranges)), [['plain', 'plain'], ['levels', 'levels of detail'], ['tiles', 'tiles']]),
      world: function (p) { return isLocal ? [0, 1, 2].map(function (a) { return origin[a] + middle[a] + p[a] * size / 2; }) : null; },
      plain: function (part, mode) {
        var pick = mode === 'levels' ? part.level : mode === 'tiles' ? part.number : -1;
        return pick < 0 ? plainColor : orbweave.hue(pick).map(function (x) { return x / 255; });
      },
      paint: function (part, mode) { return mode === 'points' ? part.paint : mode in ranges ? paintOfValue(part, mode) : paintOfFaces(part, mode); },
      choose: choose
    });
    if (!viewer) return;

    // -- which tiles
    var frame = 0, held = 0, loadedBytes = 0, requests = 0, loaded = [], missing = [], view = null;
    function isVisible(tile) {
      var from = sub(tile.middle, view.eye), depth = -dot(view.away, from), r = tile.radius;
      var t = view.tangent, s = view.tangent * view.aspect;
      return depth > -r && Math.abs(dot(view.up, from)) <= depth * t + r * Math.sqrt(1 + t * t) &&
        Math.abs(dot(view.right, from)) <= depth * s + r * Math.sqrt(1 + s * s);
    }
    /// Of the tile's error on the screen, where the tile is nearest.
    function pixelsOf(tile) {
      var out = [0, 1, 2].map(function (a) { return Math.max(0, Math.abs(view.eye[a] - tile.middle[a]) - tile.half[a]); });
      return tile.error * view.pixels / (2 * view.tangent * Math.max(Math.hypot(out[0], out[1], out[2]), 1e-9));
    }
    /// Adds what is drawn for a tile that is there: itself, or its children once all that are seen are there.
    function select(tile, drawn) {
      tile.used = frame;
      var pixels = pixelsOf(tile), finer = pixels > mostPixels ? tile.children.filter(isVisible) : [];
      var absent = finer.filter(function (child) { return child.part === null; });
      finer.forEach(function (child) { child.used = frame; });
      absent.forEach(function (child) { missing.push({ tile: child, pixels: pixels }); });
      if (pixels > mostPixels && tile.children.length > 0 && absent.length === 0) finer.forEach(function (child) { select(child, drawn); });
      else drawn.push(tile.part);
    }
    function choose(now) {
      view = now; ++frame; missing = [];
      var drawn = [];
      if (root.part) select(root, drawn); else missing.push({ tile: root, pixels: Infinity });
      root.used = frame;
      request();
      var triangles = drawn.reduce(function (sum, part) { return sum + part.corners.length / 3; }, 0);
      viewer.showFacts(facts.concat(['drawn: ' + count(triangles) + ' triangles of ' + drawn.length + ' tiles',
        'in memory: ' + count(Math.round(held / 1048576)) + ' MiB of ' + loaded.length + ' tiles; loaded: ' + count(Math.round(loadedBytes / 1048576)) + ' MiB']));
      note('drawn', drawn.length); note('triangles', triangles); note('loaded', loaded.length); note('held', held); note('waiting', requests);
      return drawn;
    }

    // -- loading and unloading
    /// Unloads what was not used longest, until there is room; false where all that is left is in use.
    function makeRoom(bytes) {
      if (held + bytes <= mostBytes) return true;
      var idle = loaded.filter(function (tile) { return tile.used < frame; }).sort(function (a, b) { return a.used - b.used || b.level - a.level; });
      while (held + bytes > mostBytes && idle.length > 0) unload(idle.shift());
      return held + bytes <= mostBytes;
    }
    function unload(tile) {
      viewer.drop(tile.part);
      tile.part = null; tile.state = 'absent'; held -= tile.bytes;
      loaded.splice(loaded.indexOf(tile), 1);
    }
    /// The coarsest picture first. The root is loaded whatever it takes.
    function request() {
      missing.sort(function (a, b) { return b.pixels - a.pixels; });
      for (var i = 0; i < missing.length && requests < mostRequests; ++i) {
        var tile = missing[i].tile;
        if (tile.state !== 'absent') continue;
        if (!makeRoom(tile.bytes) && tile !== root) { note('full', 1); return; }
        load(tile);
      }
    }
    function load(tile) {
      ++requests; tile.state = 'loading'; held += tile.bytes;
      get(tile.uri).then(function (answer) { return answer.arrayBuffer(); }).then(function (bytes) {
        loadedBytes += bytes.byteLength;
        var part = partOf(bytes, tile);
        viewer.add(part);
        tile.part = part; tile.state = 'there';
        held += part.bytes - tile.bytes; tile.bytes = part.bytes;
        loaded.push(tile);
        if (tile === root) {
          note('first-bytes', loadedBytes);
          if (!part.paint) { byId('colors').remove(0); viewer.redraw(); }
          setTimeout(function () { viewer.listHoles(welded(part), all.levels > 1 ? ' in the coarsest level' : '', filledHoles(), extras.filled_holes); }, 50);
        }
      }).catch(function (e) { tile.state = 'failed'; held -= tile.bytes; complain(String(e)); }).then(function () { --requests; viewer.redraw(); });
    }

    // -- holes
    /// With the first vertex at each place: a tile has vertices several times whose faces differ.
    function welded(part) {
      var first = null;
      if (part.hole || part.component) {
        var places = new Map();
        first = new Uint32Array(part.local.length / 3);
        for (var v = 0; v < first.length; ++v) {
          var key = part.local.subarray(3 * v, 3 * v + 3).join();
          if (!places.has(key)) places.set(key, v);
          first[v] = places.get(key);
        }
      }
      return { local: part.local, corners: part.corners, origin: part.origin, patches: [], first: first };
    }
    /// The largest, as the tileset lists them.
    function filledHoles() {
      return holes.map(function (hole) {
        return { text: viewer.filledWords(hole.hole, hole.triangles, hole.confidence), at: { middle: toDrawing(hole.middle), size: hole.diagonal * 2 / size }, normal: hole.normal };
      });
    }

    // -- GLB
    var sRgb = null;
    function fromLinear(value) {
      if (!sRgb) {
        sRgb = new Uint8Array(65536);
        for (var i = 0; i < 65536; ++i) { var x = i / 65535; sRgb[i] = Math.round(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * Math.pow(x, 1 / 2.4) - 0.055)); }
      }
      return sRgb[value];
    }
    /// The bytes of a view of rows, and where they begin there.
    function rowsOf(buffer, begin, view_) {
      var packed = (view_.extensions || {}).EXT_meshopt_compression;
      if (!packed) return { bytes: buffer, at: begin + (view_.byteOffset || 0) };
      var source = new Uint8Array(buffer, begin + (packed.byteOffset || 0), packed.byteLength), unpack = orbweave.unpack;
      var bytes = packed.mode === 'TRIANGLES' ? unpack.triangles(source, packed.count) : unpack.vertices(source, packed.count, packed.byteStride);
      return { bytes: bytes.buffer, at: 0 };
    }
    /// Rows of floats about the tile's middle, as docs/levels.md has them.
    function partOf(buffer, tile) {
      var head = new DataView(buffer), documentBytes = head.getUint32(12, true), begin = 20 + documentBytes + 8;
      if (head.getUint32(0, true) !== 0x46546C67) throw new Error(tile.uri + ': no GLB file');
      var json = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 20, documentBytes)));
      var primitive = json.meshes[0].primitives[0], matrix = json.nodes[0].matrix;
      var viewOf = function (accessor) { return json.bufferViews[accessor.bufferView]; };
      var indices = json.accessors[primitive.indices], ofIndices = rowsOf(buffer, begin, viewOf(indices));
      var corners = new Uint32Array(ofIndices.bytes.slice(ofIndices.at, ofIndices.at + 4 * indices.count));
      // All attributes lie in the same rows.
      var ofVertices = viewOf(json.accessors[primitive.attributes.POSITION]), vertexRows = rowsOf(buffer, begin, ofVertices);
      head = new DataView(vertexRows.bytes);
      var rows = function (key) {
        if (!(key in primitive.attributes)) return null;
        var accessor = json.accessors[primitive.attributes[key]];
        return { at: vertexRows.at + (accessor.byteOffset || 0), stride: ofVertices.byteStride, count: accessor.count };
      };
      var places = rows('POSITION'), normals = rows('NORMAL'), colors = rows('COLOR_0'), n = places.count;
      var local = new Float32Array(3 * n), directions = normals ? new Int8Array(4 * n) : null, paint = colors ? new Uint8Array(3 * n) : null;
      for (var v = 0; v < n; ++v)
        for (var k = 0; k < 3; ++k) {
          local[3 * v + k] = head.getFloat32(places.at + v * places.stride + 4 * k, true) * 2 / size;
          if (normals) directions[4 * v + k] = Math.round(127 * head.getFloat32(normals.at + v * normals.stride + 4 * k, true));
          if (colors) paint[3 * v + k] = fromLinear(head.getUint16(colors.at + v * colors.stride + 2 * k, true));
        }
      var floats = function (key) {
        var from = rows(key);
        if (!from) return null;
        var values = new Float32Array(n);
        for (var i = 0; i < n; ++i) values[i] = head.getFloat32(from.at + i * from.stride, true);
        return values;
      };
      // The node turns z to y, which readers of tiles turn back.
      var part = { local: local, corners: corners, normals: directions, paint: paint, origin: toDrawing([matrix[12], -matrix[14], matrix[13]]), patches: [],
        hole: floats('_HOLE'), confidence: floats('_CONFIDENCE'), component: floats('_COMPONENT'), level: tile.level, number: parseInt(tile.uri, 10) };
      part.values = {};
      Object.keys(ranges).forEach(function (name) { part.values[name] = floats('_' + name.toUpperCase()); });
      var tags = 4 * Object.keys(ranges).length + (part.hole ? 4 : 0) + (part.confidence ? 4 : 0) + (part.component ? 4 : 0);
      // Here and on the graphics card, with the lines of the wireframe.
      part.bytes = 2 * (16 * n + (paint ? 3 * n : 0)) + tags * n + 2 * 4 * corners.length + 8 * corners.length;
      return part;
    }

    if (meta.report) get('report.json').then(function (answer) { return answer.json(); }).then(viewer.showReport).catch(function (e) { complain(String(e)); });
    viewer.redraw();
  }
}());
