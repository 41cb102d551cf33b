// The viewer of both pages: draws parts of a surface, turns, measures, lists holes.
//
// viewer_mesh.js gives it one mesh that is part of its page, viewer_tiles.js tiles that come and go.
// A part has coordinates for drawing ("local", floats about its "origin"), "corners" of triangles
// and runs of "patches". Drawing coordinates are about the middle of all, whose largest extent is 2.
'use strict';
var orbweave = (function () {
  var byId = function (id) { return document.getElementById(id); };
  var shown = function (x) { return Number(x.toPrecision(7)).toString(); };

  // -- small vectors
  var sub = function (a, b) { return [a[0] - b[0], a[1] - b[1], a[2] - b[2]]; };
  var add = function (a, b, s) { return [a[0] + b[0] * s, a[1] + b[1] * s, a[2] + b[2] * s]; };
  var dot = function (a, b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  var cross = function (a, b) {
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  };
  var unit = function (a) { var l = Math.sqrt(dot(a, a)) || 1; return [a[0] / l, a[1] / l, a[2] / l]; };
  var vertex = function (part, v) {
    return [0, 1, 2].map(function (a) { return part.local[3 * v + a] + part.origin[a]; });
  };

  // -- what follows from the triangles
  function normalsOf(part) {
    var local = part.local, corners = part.corners, vertices = local.length / 3, triangles = corners.length / 3;
    var sums = new Float32Array(3 * vertices);
    for (var t = 0; t < triangles; ++t) {
      var a = 3 * corners[3 * t], b = 3 * corners[3 * t + 1], c = 3 * corners[3 * t + 2];
      var ux = local[b] - local[a], uy = local[b + 1] - local[a + 1], uz = local[b + 2] - local[a + 2];
      var vx = local[c] - local[a], vy = local[c + 1] - local[a + 1], vz = local[c + 2] - local[a + 2];
      var n = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
      for (var k = 0; k < 3; ++k) { sums[a + k] += n[k]; sums[b + k] += n[k]; sums[c + k] += n[k]; }
    }
    var normals = new Int8Array(4 * vertices);
    for (var v = 0; v < vertices; ++v) {
      var l = Math.hypot(sums[3 * v], sums[3 * v + 1], sums[3 * v + 2]) || 1;
      for (k = 0; k < 3; ++k) normals[4 * v + k] = Math.round(127 * sums[3 * v + k] / l);
    }
    return normals;
  }

  /// Of patches, by how sure they are where that is asked for: from orange (0) to blue (1).
  function patchColor(mode, confidence) {
    var sure = [0.5, 0.66, 0.89], unsure = [0.93, 0.55, 0.2];
    if (mode === 'patches') return sure;
    return mode === 'confidence' ? add(unsure, sub(sure, unsure), confidence) : null;
  }
  /// The colour modes of patches, with their words.
  var patchModes = [['patches', 'patches in blue'], ['confidence', 'confidence of patches, orange to blue']];

  /// What vertices tell of their points: words of the panel.
  var valueWords = { vertex_confidence: 'confidence of points, orange to blue', quality_spacing: 'spacing of points, blue to orange',
    quality_noise: 'noise, blue to orange', quality_moved: 'moved by cleaning, blue to orange', undersampled: 'sampled too sparsely, in orange' };
  /// Modes of the values with these names; "confidence" alone is that of patches.
  function valueModes(names) { return names.map(function (name) { return [name, valueWords[name] || name]; }); }
  /// Bytes by vertex: `share` is 0 to 1 of the value's range, below 0: not known. Orange is what is less sure.
  function valuePaint(name, count, share, plain) {
    var paint = new Uint8Array(3 * count), ramp = [];
    for (var i = 0; i < 256; ++i)
      ramp.push(patchColor('confidence', name === 'vertex_confidence' ? i / 255 : 1 - i / 255).map(function (x) { return Math.round(255 * x); }));
    var unknown = plain.map(function (x) { return Math.round(255 * x); });
    for (var v = 0; v < count; ++v) { var s = share(v); paint.set(s < 0 ? unknown : ramp[Math.round(255 * Math.min(1, s))], 3 * v); }
    return paint;
  }

  function hue(i) {
    var h = (0.55 + i * 0.61803398875) % 1 * 6, f = h - Math.floor(h), s = [[1, f, 0], [1 - f, 1, 0], [0, 1, f], [0, 1 - f, 1], [f, 0, 1], [1, 0, 1 - f]][Math.floor(h)];
    return s.map(function (x) { return Math.round(80 + 150 * x); });
  }

  /// Open edges without those of vertices that are split: there, two run against each other. `first`:
  /// the first vertex at the place of each.
  function closedAtSplits(edges, first) {
    var count = new Map(), keyOf = function (from, to) { return from * first.length + to; };
    var more = function (key, by) { count.set(key, (count.get(key) || 0) + by); };
    edges.forEach(function (edge) {
      var from = first[edge[0]], to = first[edge[1]], against = keyOf(to, from);
      if (count.get(against) > 0) more(against, -1); else more(keyOf(from, to), 1);
    });
    var left = [];
    count.forEach(function (n, key) {
      for (; n > 0; --n) left.push([Math.floor(key / first.length), key % first.length]);
    });
    return left;
  }

  /// Edges of one triangle, as loops of vertices.
  function openLoops(part) {
    var corners = part.corners, vertices = part.local.length / 3, triangles = corners.length / 3;
    var keys = new Float64Array(3 * triangles);
    for (var t = 0; t < triangles; ++t)
      for (var k = 0; k < 3; ++k) {
        var a = corners[3 * t + k], b = corners[3 * t + (k + 1) % 3];
        keys[3 * t + k] = (a < b ? a * vertices + b : b * vertices + a) * 2 + (a < b ? 0 : 1);
      }
    keys.sort();
    var open = [];
    for (var i = 0; i < keys.length;) {
      var edge = Math.floor(keys[i] / 2), end = i + 1;
      while (end < keys.length && Math.floor(keys[end] / 2) === edge) ++end;
      if (end === i + 1) {
        var low = Math.floor(edge / vertices), high = edge - low * vertices, turned = keys[i] - 2 * edge === 1;
        // Around a hole the other way than around its triangles.
        open.push(turned ? [low, high] : [high, low]);
      }
      i = end;
    }
    if (part.first) open = closedAtSplits(open, part.first);
    var next = new Map(), loops = [];
    open.forEach(function (edge) {
      if (next.has(edge[0])) next.get(edge[0]).push(edge[1]); else next.set(edge[0], [edge[1]]);
    });
    while (next.size > 0) {
      var first = next.keys().next().value, loop = [], at = first;
      // Where loops touch at a vertex, a walk goes on until it is back.
      while (next.has(at)) {
        loop.push(at);
        var ends = next.get(at), then = ends.pop();
        if (ends.length === 0) next.delete(at);
        at = then;
      }
      loops.push(loop);
    }
    return loops;
  }

  /// `scene`: name, facts, up (axis), extent and size (largest extent) of all, in scan units;
  /// colors: [mode, words] pairs, the first chosen; paint(part, mode): bytes by vertex or null;
  /// plain(part, mode): red, green and blue of what has no paint; world(p): scan coordinates or null.
  function makeViewer(scene) {
    var size = scene.size;
    // -- drawing
    var canvas = byId('view');
    var gl = canvas.getContext('webgl2', { antialias: true, preserveDrawingBuffer: true });
    if (!gl) { byId('tape').textContent = 'This browser has no WebGL 2.'; return null; }
    var vertexSource = '#version 300 es\n' +
      'in vec3 place; in vec3 normal; in vec3 paint; uniform mat4 camera; uniform vec4 plain; out vec3 at; out vec3 up; out vec3 tint;\n' +
      'void main() { at = place; up = normal; tint = mix(paint, plain.rgb, plain.a); gl_Position = camera * vec4(place, 1.0); }';
    var fragmentSource = '#version 300 es\nprecision highp float;\n' +
      'in vec3 at; in vec3 up; in vec3 tint; uniform vec3 eye; uniform vec4 section; uniform vec3 how; out vec4 color;\n' +
      'void main() {\n' +
      ' if (dot(section.xyz, at) > section.w) discard;\n' +
      ' if (how.z > 0.5) { color = vec4(tint, 1.0); return; }\n' +
      ' vec3 n = how.x > 0.5 ? normalize(up) : normalize(cross(dFdx(at), dFdy(at)));\n' +
      ' vec3 away = normalize(eye - at);\n' +
      ' if (how.x > 0.5 && !gl_FrontFacing) n = -n;\n' +
      ' float light = 0.28 + 0.72 * abs(dot(n, normalize(away + vec3(0.25, 0.3, 0.15))));\n' +
      ' vec3 base = how.y > 0.5 && !gl_FrontFacing ? vec3(0.78, 0.25, 0.2) : tint;\n' +
      ' color = vec4(base * light, 1.0);\n' +
      '}';
    var shader = function (type, source) {
      var s = gl.createShader(type); gl.shaderSource(s, source); gl.compileShader(s);
      if (!gl.getShaderParameter(s, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(s));
      return s;
    };
    var program = gl.createProgram();
    gl.attachShader(program, shader(gl.VERTEX_SHADER, vertexSource));
    gl.attachShader(program, shader(gl.FRAGMENT_SHADER, fragmentSource));
    ['place', 'normal', 'paint'].forEach(function (name, i) { gl.bindAttribLocation(program, i, name); });
    gl.linkProgram(program);
    gl.useProgram(program);
    var uniform = {};
    ['camera', 'eye', 'section', 'how', 'plain'].forEach(function (name) { uniform[name] = gl.getUniformLocation(program, name); });
    var buffer = function (target, data) {
      var b = gl.createBuffer(); gl.bindBuffer(target, b); gl.bufferData(target, data, gl.STATIC_DRAW); return b;
    };
    var parts = [];  // that are drawn
    var markState = gl.createVertexArray(), markBuffer = gl.createBuffer();

    /// Gives a part its place on the graphics card.
    function add_(part) {
      var state = part.gl = { mode: null, buffers: [] };
      state.vertices = gl.createVertexArray();
      gl.bindVertexArray(state.vertices);
      state.buffers.push(buffer(gl.ARRAY_BUFFER, part.local)); gl.enableVertexAttribArray(0); gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
      state.buffers.push(buffer(gl.ARRAY_BUFFER, part.normals || normalsOf(part))); gl.enableVertexAttribArray(1); gl.vertexAttribPointer(1, 3, gl.BYTE, true, 4, 0);
      state.paint = gl.createBuffer(); state.buffers.push(state.paint);
      state.triangles = buffer(gl.ELEMENT_ARRAY_BUFFER, part.corners); state.buffers.push(state.triangles);
      state.lines = null;
      gl.bindVertexArray(null);
    }
    function drop(part) {
      part.gl.buffers.forEach(function (b) { gl.deleteBuffer(b); });
      if (part.gl.lines) gl.deleteBuffer(part.gl.lines);
      gl.deleteVertexArray(part.gl.vertices);
      part.gl = null;
    }
    function setMode(part, mode) {
      var state = part.gl;
      if (state.mode === mode) return;
      var data = scene.paint(part, mode);
      state.mode = mode; state.painted = data !== null;
      if (data) {
        gl.bindBuffer(gl.ARRAY_BUFFER, state.paint); gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
        gl.enableVertexAttribArray(2); gl.vertexAttribPointer(2, 3, gl.UNSIGNED_BYTE, true, 0, 0);
      } else gl.disableVertexAttribArray(2);
    }

    // -- the camera: turns about a place
    var upAxis = scene.up;
    var frame = [[[0, -1, 0], [0, 0, 1], [1, 0, 0]], [[1, 0, 0], [0, 0, 1], [0, 1, 0]], [[1, 0, 0], [0, -1, 0], [0, 0, 1]]][upAxis];
    var camera = { target: [0, 0, 0], azimuth: 0.5, elevation: 0.35, distance: 3.3 };
    var home = Object.assign({}, camera, { target: [0, 0, 0] });
    function axes() {
      var ca = Math.cos(camera.azimuth), sa = Math.sin(camera.azimuth), ce = Math.cos(camera.elevation), se = Math.sin(camera.elevation);
      var away = add(add([0, 0, 0], frame[0], ce * sa), frame[1], ce * ca);
      away = add(away, frame[2], se);
      var right = unit(cross(frame[2], away));
      return { away: away, right: right, up: cross(away, right), eye: add(camera.target, away, camera.distance) };
    }
    var fieldOfView = 0.7;
    /// Of coordinates about `origin`.
    function matrix(a, aspect, origin) {
      var near = camera.distance / 100, far = camera.distance + 8, f = 1 / Math.tan(fieldOfView / 2);
      var r = a.right, u = a.up, w = a.away, e = sub(a.eye, origin), m = f / aspect;
      var x = -dot(r, e), y = -dot(u, e), z = -dot(w, e), d = 1 / (near - far);
      return new Float32Array([r[0] * m, u[0] * f, w[0] * (far + near) * d, -w[0], r[1] * m, u[1] * f, w[1] * (far + near) * d, -w[1],
        r[2] * m, u[2] * f, w[2] * (far + near) * d, -w[2], x * m, y * f, z * (far + near) * d + 2 * far * near * d, -z]);
    }

    var marks = [], wanted = false, frames = 0;
    /// Half spaces and sections keep their doubles until they are about the part.
    function drawPart(part, a, aspect, plane, mode) {
      setPlace(part.origin, a, aspect, plane);
      gl.bindVertexArray(part.gl.vertices);
      setMode(part, mode);
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, part.gl.triangles);
      gl.uniform3fv(uniform.how, [byId('smooth').checked ? 1 : 0, byId('backs').checked ? 1 : 0, 0]);
      gl.enable(gl.POLYGON_OFFSET_FILL); gl.polygonOffset(1, 1);
      var plain = scene.plain(part, mode).concat([part.gl.painted ? 0 : 1]);
      var from = 0;
      part.patches.concat([[part.corners.length / 3, 0, 0]]).forEach(function (run) {
        gl.uniform4fv(uniform.plain, plain); gl.drawElements(gl.TRIANGLES, 3 * (run[0] - from), gl.UNSIGNED_INT, 12 * from);
        var patch = patchColor(mode, run.length > 3 ? run[3] : 1);
        if (run[1] > 0) { gl.uniform4fv(uniform.plain, patch ? patch.concat([1]) : plain); gl.drawElements(gl.TRIANGLES, 3 * run[1], gl.UNSIGNED_INT, 12 * run[0]); }
        from = run[0] + run[1];
      });
      gl.disable(gl.POLYGON_OFFSET_FILL);
      if (byId('wire').checked) drawLines(part);
    }
    function drawLines(part) {
      var corners = part.corners, triangles = corners.length / 3;
      if (!part.gl.lines) {
        var lines = new Uint32Array(6 * triangles);
        for (var t = 0; t < triangles; ++t)
          for (var k = 0; k < 3; ++k) { lines[6 * t + 2 * k] = corners[3 * t + k]; lines[6 * t + 2 * k + 1] = corners[3 * t + (k + 1) % 3]; }
        part.gl.lines = buffer(gl.ELEMENT_ARRAY_BUFFER, lines);
      }
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, part.gl.lines);
      gl.uniform3fv(uniform.how, [0, 0, 1]); gl.uniform4fv(uniform.plain, [0.2, 0.2, 0.25, 1]);
      gl.drawElements(gl.LINES, 6 * triangles, gl.UNSIGNED_INT, 0);
    }
    function setPlace(origin, a, aspect, plane) {
      gl.uniformMatrix4fv(uniform.camera, false, matrix(a, aspect, origin));
      gl.uniform3fv(uniform.eye, sub(a.eye, origin));
      gl.uniform4fv(uniform.section, [plane[0], plane[1], plane[2], plane[3] - dot(plane, origin)]);
    }
    function draw() {
      wanted = false;
      var ratio = window.devicePixelRatio || 1, w = Math.round(canvas.clientWidth * ratio), h = Math.round(canvas.clientHeight * ratio);
      if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
      var a = axes(), aspect = w / h;
      if (scene.choose) parts = scene.choose({ eye: a.eye, away: a.away, right: a.right, up: a.up, aspect: aspect, pixels: h, tangent: Math.tan(fieldOfView / 2) });
      gl.viewport(0, 0, w, h);
      gl.clearColor(0.957, 0.953, 0.941, 1); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.enable(gl.DEPTH_TEST);
      if (byId('cull').checked) gl.enable(gl.CULL_FACE); else gl.disable(gl.CULL_FACE);
      var axis = Number(byId('axis').value), side = byId('flip').checked ? -1 : 1, plane = [0, 0, 0, 1e9];
      if (axis >= 0) { plane[axis] = side; plane[3] = side * (Number(byId('cut').value) / 1000 - 0.5) * 2.0001 * scene.extent[axis] / size; }
      var mode = byId('colors').value;
      parts.forEach(function (part) { drawPart(part, a, aspect, plane, mode); });
      if (marks.length > 0) {
        setPlace(marks[0], a, aspect, [0, 0, 0, 1e9]);
        var about = marks.map(function (p) { return sub(p, marks[0]); });
        gl.bindVertexArray(markState);
        gl.bindBuffer(gl.ARRAY_BUFFER, markBuffer); gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([].concat.apply([], about)), gl.DYNAMIC_DRAW);
        gl.enableVertexAttribArray(0); gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
        gl.uniform3fv(uniform.how, [0, 0, 1]); gl.uniform4fv(uniform.plain, [0.85, 0.2, 0.5, 1]);
        gl.disable(gl.DEPTH_TEST); gl.drawArrays(gl.LINE_LOOP, 0, marks.length);
      }
      gl.bindVertexArray(null);
      document.documentElement.setAttribute('data-frames', String(++frames));
    }
    function redraw() { if (!wanted) { wanted = true; requestAnimationFrame(draw); } }

    // -- what the pointer is on
    function ray(x, y) {
      var a = axes(), box = canvas.getBoundingClientRect(), h = Math.tan(fieldOfView / 2);
      var u = ((x - box.left) / box.width * 2 - 1) * h * box.width / box.height, v = (1 - (y - box.top) / box.height * 2) * h;
      return { from: a.eye, to: unit(add(add(add([0, 0, 0], a.away, -1), a.right, u), a.up, v)) };
    }
    function hit(x, y) {
      var r = ray(x, y), best = Infinity;
      parts.forEach(function (part) { best = Math.min(best, along(part, sub(r.from, part.origin), r.to)); });
      return best < Infinity ? add(r.from, r.to, best) : null;
    }
    /// How far the first triangle of a part is along a ray.
    function along(part, o, d) {
      var local = part.local, corners = part.corners, best = Infinity;
      for (var t = 0; t < corners.length / 3; ++t) {
        var a = 3 * corners[3 * t], b = 3 * corners[3 * t + 1], c = 3 * corners[3 * t + 2];
        var e1x = local[b] - local[a], e1y = local[b + 1] - local[a + 1], e1z = local[b + 2] - local[a + 2];
        var e2x = local[c] - local[a], e2y = local[c + 1] - local[a + 1], e2z = local[c + 2] - local[a + 2];
        var px = d[1] * e2z - d[2] * e2y, py = d[2] * e2x - d[0] * e2z, pz = d[0] * e2y - d[1] * e2x;
        var det = e1x * px + e1y * py + e1z * pz;
        if (det === 0) continue;
        var sx = o[0] - local[a], sy = o[1] - local[a + 1], sz = o[2] - local[a + 2];
        var u = (sx * px + sy * py + sz * pz) / det;
        if (!(u >= 0 && u <= 1)) continue;
        var qx = sy * e1z - sz * e1y, qy = sz * e1x - sx * e1z, qz = sx * e1y - sy * e1x;
        var v = (d[0] * qx + d[1] * qy + d[2] * qz) / det;
        if (!(v >= 0 && u + v <= 1)) continue;
        var s = (e2x * qx + e2y * qy + e2z * qz) / det;
        if (s > 0 && s < best) best = s;
      }
      return best;
    }

    var flightMs = 400;
    /// `facing`: the direction to look from, or null: the one there is.
    function fly(target, distance, facing) {
      var duration = flightMs;
      var begin = null, t0 = camera.target, d0 = camera.distance, a0 = camera.azimuth, e0 = camera.elevation, turn = 0, rise = 0;
      if (facing && Math.hypot(facing[0], facing[1], facing[2]) > 0) {
        var n = unit(facing);
        rise = Math.max(-1.5, Math.min(1.5, Math.asin(Math.max(-1, Math.min(1, dot(n, frame[2])))))) - e0;
        turn = Math.atan2(dot(n, frame[0]), dot(n, frame[1])) - a0;
        turn -= 2 * Math.PI * Math.round(turn / (2 * Math.PI));
      }
      var step = function (now) {
        if (begin === null) begin = now;
        var s = Math.min(1, duration > 0 ? (now - begin) / duration : 1);
        s = s * s * (3 - 2 * s);
        camera.target = add(t0, sub(target, t0), s); camera.distance = d0 + (distance - d0) * s;
        camera.azimuth = a0 + turn * s; camera.elevation = e0 + rise * s;
        redraw();
        if (s < 1) requestAnimationFrame(step);
      };
      requestAnimationFrame(step);
    }
  
    // -- the pointer
    var pointers = new Map(), moved = 0, ruler = [];
    function pan(dx, dy) {
      var a = axes(), s = camera.distance * 2 * Math.tan(fieldOfView / 2) / canvas.clientHeight;
      camera.target = add(add(camera.target, a.right, -dx * s), a.up, dy * s);
    }
    canvas.addEventListener('contextmenu', function (e) { e.preventDefault(); });
    canvas.addEventListener('pointerdown', function (e) { canvas.setPointerCapture(e.pointerId); pointers.set(e.pointerId, [e.clientX, e.clientY]); moved = 0; });
    canvas.addEventListener('pointerup', function (e) {
      pointers.delete(e.pointerId);
      if (moved < 4 && e.shiftKey) measure(e.clientX, e.clientY);
    });
    canvas.addEventListener('pointercancel', function (e) { pointers.delete(e.pointerId); });
    canvas.addEventListener('pointermove', function (e) {
      var last = pointers.get(e.pointerId);
      if (!last) return;
      var dx = e.clientX - last[0], dy = e.clientY - last[1];
      moved += Math.abs(dx) + Math.abs(dy);
      if (pointers.size === 2) {
        var other = null;
        pointers.forEach(function (p, id) { if (id !== e.pointerId) other = p; });
        var before = Math.hypot(last[0] - other[0], last[1] - other[1]), after = Math.hypot(e.clientX - other[0], e.clientY - other[1]);
        if (after > 0) camera.distance *= before / after;
        pan(dx / 2, dy / 2);
      } else if (e.buttons & 2 || e.ctrlKey) pan(dx, dy);
      else if (!e.shiftKey) {
        camera.azimuth -= dx * 0.006;
        camera.elevation = Math.max(-1.55, Math.min(1.55, camera.elevation + dy * 0.006));
      }
      pointers.set(e.pointerId, [e.clientX, e.clientY]);
      redraw();
    });
    canvas.addEventListener('wheel', function (e) {
      e.preventDefault();
      camera.distance = Math.max(1e-4, Math.min(40, camera.distance * Math.exp(e.deltaY * 0.0012)));
      redraw();
    }, { passive: false });
    canvas.addEventListener('dblclick', function (e) { var p = hit(e.clientX, e.clientY); if (p) fly(p, camera.distance * 0.5); });
    function measure(x, y) {
      var p = hit(x, y);
      if (!p) return;
      if (ruler.length === 2) ruler = [];
      ruler.push(p);
      marks = ruler.slice();
      var place = scene.world(ruler[0]), lines = place ? ['at ' + place.map(shown).join(', ')] : ['at the first point'];
      if (ruler.length === 2) {
        var along = sub(ruler[1], ruler[0]).map(function (x) { return x * size / 2; });
        lines = ['distance ' + shown(Math.hypot(along[0], along[1], along[2])), 'by axis ' + along.map(shown).join(', ')];
      }
      byId('tape').textContent = lines.join('\n');
      redraw();
    }

    // -- the panel
    byId('name').textContent = scene.name;
    document.title = scene.name + ' - orbweave';
    function showFacts(facts) {
      byId('facts').textContent = '';
      facts.forEach(function (line) { var p = document.createElement('div'); p.textContent = line; byId('facts').appendChild(p); });
    }
    showFacts(scene.facts);
    scene.colors.forEach(function (m) { var o = document.createElement('option'); o.value = m[0]; o.textContent = m[1]; byId('colors').appendChild(o); });
    ['colors', 'wire', 'smooth', 'backs', 'cull', 'axis', 'cut', 'flip'].forEach(function (id) { byId(id).addEventListener('input', redraw); });
    byId('toggle').addEventListener('click', function () { byId('side').classList.toggle('closed'); canvas.classList.toggle('wide'); redraw(); });
    byId('home').addEventListener('click', function () {
      marks = []; ruler = []; byId('tape').textContent = '';
      camera.azimuth = home.azimuth; camera.elevation = home.elevation;
      fly(home.target, home.distance);
    });
    window.addEventListener('resize', redraw);
    /// Of the address: "#colors=patches&axis=2&cut=400&cull=1&hole=1" sets the panel's fields and
    /// flies to that hole of the list. A colour that is not there yet may come with the first tile.
    var linked = new URLSearchParams(location.hash.slice(1));
    function applyLink() {
      ['colors', 'axis', 'cut'].forEach(function (id) { if (linked.has(id)) byId(id).value = linked.get(id); });
      ['wire', 'smooth', 'backs', 'cull', 'flip'].forEach(function (id) { if (linked.has(id)) byId(id).checked = linked.get(id) !== '0'; });
      if (byId('colors').selectedIndex < 0) byId('colors').selectedIndex = 0;
    }
    applyLink();
    function showReport(report) {
      var details = document.createElement('details'), pre = document.createElement('pre'), title = document.createElement('summary');
      title.textContent = 'Report'; pre.textContent = JSON.stringify(report, null, 1);
      details.appendChild(title); details.appendChild(pre); byId('report').appendChild(details);
    }

    function place(part, points) {
      var low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
      points.forEach(function (v) { var p = vertex(part, v); for (var a = 0; a < 3; ++a) { low[a] = Math.min(low[a], p[a]); high[a] = Math.max(high[a], p[a]); } });
      return { middle: add(add([0, 0, 0], low, 0.5), high, 0.5), size: Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]) };
    }
    /// Words of a hole that is filled; `confidence`: undefined where it is not known.
    function filledWords(hole, triangles, confidence) {
      return 'filled, hole ' + hole + ', ' + triangles + ' triangles' + (confidence === undefined ? '' : ', confidence ' + confidence.toFixed(2));
    }
    /// Those of one part, and `filled` ones ({ text, at }); `of`: words after the number of open
    /// ones, where the part is not the mesh itself; `filledCount`: where not all are in the list.
    function listHoles(part, of, filled, filledCount) {
      var entries = openLoops(part).map(function (loop) {
        var at = place(part, loop);
        var first = vertex(part, loop[0]), normal = [0, 0, 0];
        for (var i = 1; i + 1 < loop.length; ++i)
          normal = add(normal, cross(sub(vertex(part, loop[i]), first), sub(vertex(part, loop[i + 1]), first)), 1);
        return { text: 'open, ' + loop.length + ' edges', at: at, normal: normal, loop: loop };
      });
      part.patches.forEach(function (run) {
        var used = new Set(), normal = [0, 0, 0];
        for (var i = 3 * run[0]; i < 3 * (run[0] + run[1]); i += 3) {
          var corners = [0, 1, 2].map(function (k) { used.add(part.corners[i + k]); return vertex(part, part.corners[i + k]); });
          normal = add(normal, cross(sub(corners[1], corners[0]), sub(corners[2], corners[0])), 1);
        }
        entries.push({ text: filledWords(run[2], run[1], run[3]), at: place(part, Array.from(used)), normal: normal, loop: null });
      });
      entries = entries.concat(filled || []);
      entries.sort(function (a, b) { return (b.loop ? 1 : 0) - (a.loop ? 1 : 0) || b.at.size - a.at.size; });
      var isOpen = function (e) { return Boolean(e.loop); }, most = 150;
      var open = entries.filter(isOpen).length, closed = filledCount || entries.length - open;
      entries = entries.slice(0, Math.min(open, most)).concat(entries.slice(open, open + most));
      byId('holecount').textContent = open + ' open' + (of || '') + ', ' + closed + ' filled' + (entries.length < open + closed ? '; the largest:' : '');
      entries.forEach(function (entry) {
        var item = document.createElement('li'), button = document.createElement('button');
        button.textContent = entry.text + ', ' + shown(entry.at.size * size / 2).slice(0, 7) + ' wide';
        button.addEventListener('click', function () {
          marks = entry.loop ? entry.loop.map(function (v) { return vertex(part, v); }) : [];
          fly(entry.at.middle, Math.max(entry.at.size * 2.5, 0.01), entry.normal);
        });
        item.appendChild(button); byId('holes').appendChild(item);
      });
      var flown = byId('holes').children[Number(linked.get('hole')) - 1];
      // A link leads there at once.
      if (flown) { flightMs = 0; flown.firstChild.click(); flightMs = 400; }
      document.documentElement.setAttribute('data-holes', String(open));
      document.documentElement.setAttribute('data-filled', String(closed));
    }

    return { add: add_, drop: drop, draw: draw, redraw: redraw, fly: fly, camera: camera, listHoles: listHoles, filledWords: filledWords, showFacts: showFacts, showReport: showReport,
      show: function (all) { parts = all; redraw(); } };
  }

  return { makeViewer: makeViewer, byId: byId, hue: hue, patchColor: patchColor, valueModes: valueModes, valuePaint: valuePaint, patchModes: patchModes, sub: sub, dot: dot };
}());
