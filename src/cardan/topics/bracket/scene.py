"""A bracket to turn about in a browser: one page, nothing fetched, nothing sent."""

import base64
import json
from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np
import numpy.typing as npt

from cardan.approval.approval import Approval
from cardan.approval.study import BRACKET_STUDY_NAME
from cardan.core.units import MPa
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.text_layout import without_colours
from cardan.topics.bracket.assessment import BracketResult
from cardan.topics.bracket.phrases import bracket_heading
from cardan.topics.bracket.presentation import verdict_lines
from cardan.topics.bracket.presentation_values import MAX_MARKED_FATIGUE_FEATURES
from cardan.topics.bracket.shape_result import CaseResult, ShapeAssessment
from cardan.topics.bracket.vtk_file import displacement_and_stress_at_case_peak


def html_page(approval: Approval, *, say: Translator = ENGLISH) -> str:
    """Return a page with the verdict on a bracket, its limits, and its scene."""
    say = say.with_minus_sign
    of: BracketResult = approval.answer_of(BRACKET_STUDY_NAME)
    title = escape(bracket_heading(of, say))
    first, _, limits = without_colours(verdict_lines(approval, say)).partition("\n")
    grade, said = approval.verdict, escape(first)
    return (
        f'<!doctype html><html lang="{say.code}"><meta charset="utf-8">'
        f'<title>{title}</title><body style="font:14px system-ui,sans-serif;margin:1em">'
        f'<h1 style="font-size:1.2em">{title}</h1>'
        f'<p class="{grade}" style="font-size:1.2em"><strong>{said}</strong></p>'
        f'<pre style="overflow:auto">{escape(limits)}</pre>'
        f"{scene_html(of, say=say)}</body></html>\n"
    )


def scene_html(of: BracketResult, *, say: Translator = ENGLISH) -> str:
    """Return a fragment of HTML: the mesh, each case's stress, deformation, gauges, hot spots.

    Drag to turn, wheel to zoom; the deformation runs from none to plenty. It opens with the case
    that stresses the first variant most.
    """
    first = of.variants[0].case_results
    order = sorted(range(len(first)), key=lambda k: -first[k].von_mises.value)
    data = {
        "variants": [
            variant_scene_data(v, [v.case_results[k] for k in order], say) for v in of.variants
        ],
        "words": {
            "none": say("This browser shows no WebGL."),
            "scale": say("blue 0 to red {top} MPa, von Mises", top="@"),
            "point": say.with_decimal_sign("1.5")[1],
        },
        "gauges": [{"name": g.name, "at": list(g.point)} for g in of.bracket.gauges],
    }
    # A script ends at the first "</", whatever it stands in.
    packed = json.dumps(data, separators=(",", ":")).replace("</", "<\\/")
    fragment = _FRAGMENT
    for label in ("shape", "case", "deformation"):
        fragment = fragment.replace(f"@{label}@", escape(say(label)))
    return fragment.replace("@DATA@", packed)


def variant_scene_data(
    v: ShapeAssessment, outcomes: Sequence[CaseResult], say: Translator
) -> dict[str, Any]:
    """Return a variant's surface, m, with what some cases do to it when they peak.

    Arrays are packed: bytes of little-endian numbers of four bytes, in base64. Displacements `u`
    are in m, stresses `s` in MPa, `faces` are triangles of places among the points.
    """
    nodes = v.solved.nodes
    kept = nodes.surface_nodes
    place = np.full(len(nodes.points), -1, dtype=np.int64)
    place[kept] = np.arange(len(kept))
    corners = nodes.faces[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]].reshape(-1, 3)
    cases: list[dict[str, Any]] = []
    for o in outcomes:
        u, mises = displacement_and_stress_at_case_peak(v, o)
        cases.append({
            "name": say.occasion(o.case.when),
            "u": _packed(u[kept].astype("<f4")),
            "s": _packed((mises[kept] / MPa).astype("<f4")),
            "top": o.von_mises.value / MPa,
        })  # fmt: skip
    return {
        "name": say(v.name),
        "points": _packed(nodes.points[kept].astype("<f4")),
        "faces": _packed(place[corners].astype("<u4")),
        "spots": [list(f.point) for f in v.listed_features[:MAX_MARKED_FATIGUE_FEATURES]],
        "cases": cases,
    }


def _packed(values: npt.NDArray[Any]) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode()


_FRAGMENT = """
<div class="bracket-scene">
<p><label>@shape@ <select class="v"></select></label>
<label>@case@ <select class="c"></select></label>
<label>@deformation@ <input class="d" type="range" min="0" max="1" step="0.01" value="0.3"></label>
<span class="b" style="display:inline-block;width:10em;height:.8em;border:1px solid #888;
background:linear-gradient(90deg,#0d0dff 12%,#0dffff 37%,#80ff80 50%,#ffff0d 62%,#ff0d0d 88%)">
</span> <span class="k"></span></p>
<div style="position:relative;width:100%;max-width:900px">
<canvas style="width:100%;height:560px;border:1px solid #ccc;touch-action:none"></canvas>
<div class="m" style="position:absolute;inset:0;pointer-events:none;overflow:hidden"></div></div>
<script type="application/json">@DATA@</script>
<script>
(() => {
const root = document.currentScript.parentElement, q = s => root.querySelector(s);
const data = JSON.parse(q('script[type="application/json"]').textContent);
const canvas = q('canvas'), gl = canvas.getContext('webgl'), marks = q('.m');
if (!gl || !gl.getExtension('OES_element_index_uint') ||
    !gl.getExtension('OES_standard_derivatives')) {
  q('.k').textContent = data.words.none; return;
}
const bytes = t => Uint8Array.from(atob(t), c => c.charCodeAt(0)).buffer;
const shader = (kind, text) => {
  const s = gl.createShader(kind); gl.shaderSource(s, text); gl.compileShader(s); return s;
};
const program = gl.createProgram();
gl.attachShader(program, shader(gl.VERTEX_SHADER, `
attribute vec3 p; attribute vec3 u; attribute float s;
uniform mat3 turn; uniform vec3 mid; uniform vec2 zoom; uniform float plenty;
varying float tone; varying vec3 seen;
void main() {
  seen = turn * (p + plenty * u - mid); tone = s;
  gl_Position = vec4(seen.x * zoom.x, seen.y * zoom.y, -seen.z * zoom.y * 0.3, 1.0);
}`));
gl.attachShader(program, shader(gl.FRAGMENT_SHADER, `
#extension GL_OES_standard_derivatives : enable
precision highp float;
varying float tone; varying vec3 seen; uniform float top;
void main() {
  vec3 n = normalize(cross(dFdx(seen), dFdy(seen)));
  float t = clamp(tone / top, 0.0, 1.0);
  vec3 c = clamp(vec3(4.0*t-1.5, 1.5-abs(4.0*t-2.0), 2.5-4.0*t), 0.05, 1.0);
  gl_FragColor = vec4(c * (0.45 + 0.55 * abs(n.z)), 1.0);
}`));
gl.linkProgram(program); gl.useProgram(program); gl.enable(gl.DEPTH_TEST);
const spot = name => gl.getUniformLocation(program, name);
const fill = (name, values, size) => {
  const at = gl.getAttribLocation(program, name);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
  gl.enableVertexAttribArray(at); gl.vertexAttribPointer(at, size, gl.FLOAT, false, 0, 0);
};
let yaw = -0.6, tilt = 0.4, near = 1.6, count = 0, mid = [0,0,0], size = 1, swing = 1, v, c;
const choose = (list, names) => {
  list.replaceChildren(...names.map((n, k) => new Option(n, k)));
};
const load = () => {
  v = data.variants[q('.v').value];
  const p = new Float32Array(bytes(v.points)), f = new Uint32Array(bytes(v.faces));
  const low = [0,1,2].map(k => Infinity), high = [0,1,2].map(k => -Infinity);
  p.forEach((x, i) => { low[i%3] = Math.min(low[i%3], x); high[i%3] = Math.max(high[i%3], x); });
  mid = low.map((x, k) => (x + high[k]) / 2);
  size = Math.max(...low.map((x, k) => high[k] - x));
  fill('p', p, 3);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, f, gl.STATIC_DRAW); count = f.length; pick();
};
const pick = () => {
  c = v.cases[q('.c').value];
  const u = new Float32Array(bytes(c.u)); swing = u.reduce((a, x) => Math.max(a, Math.abs(x)), 0);
  fill('u', u, 3); fill('s', new Float32Array(bytes(c.s)), 1);
  const top = c.top.toFixed(1).replace('.', data.words.point);
  q('.k').textContent = data.words.scale.replace('@', top); draw();
};
const draw = () => {
  canvas.width = canvas.clientWidth; canvas.height = canvas.clientHeight;
  const [a, b, d, e] = [Math.cos(yaw), Math.sin(yaw), Math.cos(tilt), Math.sin(tilt)];
  // Rows: to the right, up, towards the eye.
  const m = [[-b, a, 0], [-a*e, -b*e, d], [a*d, b*d, e]];
  const zy = near / size, zx = zy * canvas.height / canvas.width;
  gl.viewport(0, 0, canvas.width, canvas.height);
  gl.clearColor(1, 1, 1, 1); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.uniformMatrix3fv(spot('turn'), false, [0,1,2].flatMap(k => m.map(row => row[k])));
  gl.uniform3fv(spot('mid'), mid); gl.uniform2f(spot('zoom'), zx, zy);
  gl.uniform1f(spot('plenty'), q('.d').value * 0.1 * size / (swing || 1));
  gl.uniform1f(spot('top'), c.top || 1);
  gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 0);
  const all = [...data.gauges, ...v.spots.map((at, k) => ({name: 'H' + (k + 1), at}))];
  marks.replaceChildren(...all.map(({name, at}) => {
    const r = m.map(row => row.reduce((t, x, k) => t + x * (at[k] - mid[k]), 0));
    const s = document.createElement('span'); s.textContent = '\\u25cf ' + name;
    s.style.cssText = `position:absolute;left:${(1 + r[0]*zx)*50}%;top:${(1 - r[1]*zy)*50}%;` +
      'transform:translate(-4px,-50%);font-size:12px;text-shadow:0 0 3px #fff,0 0 3px #fff';
    return s;
  }));
};
canvas.onpointermove = e => {
  if (e.buttons) { yaw -= e.movementX / 150; tilt += e.movementY / 150; draw(); }
};
canvas.onwheel = e => { e.preventDefault(); near *= Math.exp(-e.deltaY / 800); draw(); };
choose(q('.v'), data.variants.map(x => x.name));
choose(q('.c'), data.variants[0].cases.map(x => x.name));
q('.v').onchange = load; q('.c').onchange = pick; q('.d').oninput = draw; onresize = draw; load();
})();
</script></div>
"""
