// The mesh that is part of the page, for viewer.js.
(function () {
  var byId = orbweave.byId, hue = orbweave.hue;
  var meta = JSON.parse(byId('meta').textContent);
  var text = atob(byId('data').textContent.trim());
  byId('data').remove();
  var bytes = new Uint8Array(text.length);
  for (var i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  text = null;

  // The parts of the data, in their order.
  var vertices = meta.vertices, triangles = meta.triangles;
  var corners = new Uint32Array(bytes.buffer, 0, 3 * triangles);
  var steps = new Uint16Array(bytes.buffer, 12 * triangles, 3 * vertices);
  var paint = meta.colors ? new Uint8Array(bytes.buffer, 12 * triangles + 6 * vertices, 3 * vertices) : null;

  var atValues = 12 * triangles + (meta.colors ? 9 : 6) * vertices, plainColor = [0.86, 0.82, 0.74];
  /// Steps of 1/254 of the range; 255: not known.
  function paintOfValue(name) {
    var steps = new Uint8Array(bytes.buffer, atValues + meta.values.indexOf(name) * vertices, vertices);
    return orbweave.valuePaint(name, vertices, function (v) { return steps[v] === 255 ? -1 : steps[v] / 254; }, plainColor);
  }

  // Coordinates for drawing: about the middle, the largest extent is 2.
  var local = new Float32Array(3 * vertices);
  var middle = [0, 1, 2].map(function (a) { return meta.extent[a] / 2; });
  var size = Math.max(meta.extent[0], meta.extent[1], meta.extent[2]) || 1;
  for (i = 0; i < local.length; ++i) local[i] = (steps[i] * meta.step - middle[i % 3]) * 2 / size;

  function componentColors() {
    var parent = new Uint32Array(vertices);
    for (var v = 0; v < vertices; ++v) parent[v] = v;
    var find = function (v) {
      while (parent[v] !== v) { parent[v] = parent[parent[v]]; v = parent[v]; }
      return v;
    };
    for (var t = 0; t < triangles; ++t) {
      var a = find(corners[3 * t]);
      for (var k = 1; k < 3; ++k) { var b = find(corners[3 * t + k]); if (b < a) { parent[a] = b; a = b; } else parent[b] = a; }
    }
    var sizes = new Uint32Array(vertices);
    for (v = 0; v < vertices; ++v) ++sizes[find(v)];
    var roots = [];
    for (v = 0; v < vertices; ++v) if (sizes[v] > 0) roots.push(v);
    roots.sort(function (x, y) { return sizes[y] - sizes[x] || x - y; });
    var colors = {}, result = new Uint8Array(3 * vertices);
    roots.forEach(function (root, rank) { colors[root] = hue(rank); });
    for (v = 0; v < vertices; ++v) result.set(colors[find(v)], 3 * v);
    return result;
  }

  var colors = [['plain', 'plain']];
  if (paint) colors.unshift(['points', 'of the points']);
  if (meta.patches.length > 0) {
    var modes = orbweave.patchModes.slice(0, meta.patches[0].length > 3 ? 2 : 1);
    colors = paint ? colors.concat(modes) : modes.concat(colors);
  }
  colors = colors.concat(orbweave.valueModes(meta.values), [['components', 'components']]);
  var ofComponents = null;
  var viewer = orbweave.makeViewer({
    name: meta.name, facts: meta.facts, up: meta.up, extent: meta.extent, size: size, colors: colors,
    world: function (p) { return [0, 1, 2].map(function (a) { return meta.min[a] + middle[a] + p[a] * size / 2; }); },
    plain: function () { return plainColor; },
    paint: function (part, mode) {
      if (mode === 'components' && !ofComponents) ofComponents = componentColors();
      if (meta.values.indexOf(mode) >= 0) return paintOfValue(mode);
      return mode === 'points' ? paint : mode === 'components' ? ofComponents : null;
    }
  });
  if (!viewer) return;
  var mesh = { local: local, corners: corners, origin: [0, 0, 0], patches: meta.patches };
  viewer.add(mesh);
  viewer.show([mesh]);
  viewer.draw();
  if (meta.report) viewer.showReport(meta.report);
  setTimeout(function () { viewer.listHoles(mesh); }, 50);
}());
