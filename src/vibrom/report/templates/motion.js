"use strict";
// The moving beam: displacements are a few shapes times whole numbers of each frame (#motion-data).
(() => {
  const scenes = JSON.parse(document.getElementById("motion-data").textContent);
  const home = document.querySelector(".motion");
  if (!home || !Object.keys(scenes).length) return;
  const part = name => home.querySelector(name);
  const [sceneBox, modelBox, play, slider, now, canvas] = [".scene", ".model", ".play", ".time", ".now", "canvas"].map(part);
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer;
  const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  let scene, box, timer = 0;

  function open(name) {
    scene = scenes[name];
    if (!scene.basis) {
      scene.basis = new Float32Array(bytes(scene.shapes));
      for (const model of scene.models) {
        model.values = new Int16Array(bytes(model.motion));
        model.frames = model.values.length / scene.rank;
      }
      scene.limits = limits();
    }
    box = scene.limits;
    modelBox.replaceChildren(...scene.models.slice(1).map(model => new Option(model.title, model.method)));
    slider.max = scene.frames - 1;
    slider.value = 0;
    show();
  }

  // Positions (x, y, x, y, ...) of the outline in a frame.
  function positions(model, frame) {
    const size = scene.rest.length, found = Float64Array.from(scene.rest);
    for (let k = 0; k < scene.rank; k++) {
      const factor = model.values[frame * scene.rank + k];
      for (let i = 0; i < size; i++) found[i] += factor * scene.basis[k * size + i];
    }
    return found;
  }

  function limits() {
    const found = [Infinity, -Infinity, Infinity, -Infinity];
    for (let frame = 0; frame < scene.frames; frame += 3) {
      const at = positions(scene.models[0], frame);
      for (let i = 0; i < at.length; i += 2) {
        found[0] = Math.min(found[0], at[i]); found[1] = Math.max(found[1], at[i]);
        found[2] = Math.min(found[2], at[i + 1]); found[3] = Math.max(found[3], at[i + 1]);
      }
    }
    const pad = 0.06 * Math.max(found[1] - found[0], found[3] - found[2]);
    return [found[0] - pad, found[1] + pad, found[2] - pad, found[3] + pad];
  }

  function frameOf(context, width, height) {
    const scale = Math.min(width / (box[1] - box[0]), height / (box[3] - box[2]));
    const left = (width - scale * (box[1] - box[0])) / 2, top = (height - scale * (box[3] - box[2])) / 2;
    return (x, y) => [left + scale * (x - box[0]), height - top - scale * (y - box[2])];
  }

  function outline(context, place, at) {
    context.beginPath();
    let from = 0;
    for (const length of scene.loops) {
      for (let i = from; i < from + length; i++) {
        const [x, y] = place(at[2 * i], at[2 * i + 1]);
        i === from ? context.moveTo(x, y) : context.lineTo(x, y);
      }
      from += length;
    }
  }

  const chosen = () => scene.models.find(model => model.method === modelBox.value) || scene.models[1];

  function show() {
    const frame = Number(slider.value), ratio = devicePixelRatio || 1;
    const width = canvas.clientWidth, height = Math.max(220, Math.min(460, width * (box[3] - box[2]) / (box[1] - box[0])));
    canvas.width = width * ratio; canvas.height = height * ratio; canvas.style.height = `${height}px`;
    const context = canvas.getContext("2d");
    context.scale(ratio, ratio);
    const place = frameOf(context, width, height), full = scene.models[0], model = chosen();
    context.lineJoin = "round";
    context.setLineDash([1, 4]); context.strokeStyle = css("--soft"); context.lineWidth = 1; context.beginPath();
    for (let k = Math.max(0, frame - 25); k <= frame; k++) {
      const at = positions(full, k), [x, y] = place(at[2 * scene.tip], at[2 * scene.tip + 1]);
      k === Math.max(0, frame - 25) ? context.moveTo(x, y) : context.lineTo(x, y);
    }
    context.stroke(); context.setLineDash([]);
    const true_ = positions(full, frame);
    outline(context, place, true_);
    context.fillStyle = css("--rule"); context.strokeStyle = css("--soft"); context.lineWidth = 3; context.fill(); context.stroke();
    let words = `full order: free end at ${tipOf(true_)}`;
    if (model && frame < model.frames) {
      const at = positions(model, frame);
      outline(context, place, at);
      context.strokeStyle = css("--bad"); context.lineWidth = 1.5; context.stroke();
      words += `; ${model.title.split(":")[0]}: ${tipOf(at)}`;
    } else if (model) words += `; ${model.title.split(":")[0]}: no value any more`;
    const time = (scene.start + frame * scene.step).toFixed(4);
    now.textContent = `${time} s`;
    slider.setAttribute("aria-valuetext", `${time} seconds`);
    canvas.setAttribute("aria-label", `Beam in case ${sceneBox.value} at ${time} s; ${words}`);
  }

  const tipOf = at => `x ${at[2 * scene.tip].toFixed(3)} m, y ${at[2 * scene.tip + 1].toFixed(3)} m`;

  function run(on) {
    clearInterval(timer);
    timer = on ? setInterval(() => { slider.value = (Number(slider.value) + 1) % scene.frames; show(); }, still.matches ? 400 : 40) : 0;
    play.setAttribute("aria-pressed", String(Boolean(on)));
    play.textContent = on ? "pause" : "play";
  }

  sceneBox.replaceChildren(...Object.keys(scenes).map(name => new Option(name, name)));
  sceneBox.value = Object.keys(scenes).at(-1); // the last case bends most
  sceneBox.addEventListener("change", () => open(sceneBox.value));
  modelBox.addEventListener("change", show);
  slider.addEventListener("input", () => { run(false); show(); });
  play.addEventListener("click", () => run(!timer));
  for (const change of ["resize", "beforeprint", "afterprint"]) addEventListener(change, show);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", show);
  document.addEventListener("method", event => {
    if (scene.models.some(model => model.method === event.detail)) { modelBox.value = event.detail; show(); }
  });
  open(sceneBox.value);
})();
