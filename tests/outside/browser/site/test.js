// What the test in `tests/tests/browser.rs` has a browser do. All that is found goes back to it, as POSTs to
// `/picture/…`, `/say`, `/fail` and at last `/done`.

import init, { Painter, scene_names, shader_names, shader_sources } from './browser.js';

const post = (path, body) => fetch(path, { method: 'POST', body });
const say = words => post('/say', words);
const fail = words => post('/fail', words);

// A panic in Rust only says "unreachable" to JavaScript; what it has to say goes to the console.
const complaints = [];
const complain = console.error;
console.error = (...words) => { complaints.push(words.join(' ')); complain(...words); };
const reason = error => [...complaints, `${error}\n${error?.stack ?? ''}`].join('\n');

async function main() {
  await init();
  await compileShaders();
  for (const backend of ['cpu', 'wgpu']) await paint(backend);
  for (const backend of ['cpu', 'wgpu']) await usePage(backend);
}

// All of them on a device that has no more than WebGPU promises.
async function compileShaders() {
  const adapter = await navigator.gpu?.requestAdapter();
  if (!adapter) throw new Error('this browser has no WebGPU');
  const device = await adapter.requestDevice();
  const [names, sources] = [shader_names(), shader_sources()];
  await say(`compiling shaders on ${adapter.info.vendor} ${adapter.info.architecture}`);
  for (const [i, name] of names.entries()) {
    const module = device.createShaderModule({ label: name, code: sources[i] });
    const { messages } = await module.getCompilationInfo();
    for (const { type, lineNum, message } of messages) {
      await fail(`${name}.wgsl:${lineNum}: ${type}: ${message}`);
    }
    const compute = { module, entryPoint: name };
    await device.createComputePipelineAsync({ label: name, layout: 'auto', compute })
      .catch(error => fail(`${name}: ${error.message}`));
    await say(`${name} compiled`);
  }
  device.destroy();
}

// What is quick is drawn twice, and then the second is timed: the first may have compiled shaders.
async function paint(backend) {
  const painter = await Painter.open(backend);
  await say(`${backend} on ${painter.device()}`);
  for (const [i, name] of scene_names().entries()) {
    try {
      let began = performance.now();
      const pixels = await painter.draw(i);
      if (performance.now() - began < 1000) {
        began = performance.now();
        const again = await painter.draw(i);
        const isSame = pixels.every((value, at) => value === again[at]);
        if (!isSame) await fail(`${backend}, ${name}: not the same again`);
      }
      const ms = performance.now() - began;
      await post(`/picture/${backend}/${i}/${ms.toFixed(1)}`, pixels);
    } catch (error) {
      await fail(`${backend}, ${name}: ${reason(error)}`);
      return;
    }
  }
  const refusal = painter.refusal(0);
  const expected = backend === 'cpu' ? '' : 'a page in a browser cannot wait';
  if (!refusal.includes(expected) || !refusal === (backend === 'wgpu')) {
    await fail(`${backend}: waiting for a frame says '${refusal}'`);
  }
}

// The page of `tests/outside/page`, as a user uses it: it draws, is turned, and shows a file that is dropped.
async function usePage(backend) {
  const frame = document.createElement('iframe');
  frame.width = frame.height = 500;
  frame.src = `index.html?backend=${backend}&volume=sphere&voxels=16&pixels=96`;
  document.body.replaceChildren(frame);
  await new Promise(loaded => { frame.onload = loaded; });
  const { contentWindow: page, contentDocument: inside } = frame;
  const canvas = inside.getElementById('canvas');
  const note = inside.getElementById('note');
  const pixels = () => canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
  // Of the colours alone: a canvas is transparent before anything is drawn.
  const differ = (a, b) => a.reduce((n, value, at) => n + (at % 4 < 3 && Math.abs(value - b[at]) > 8), 0);
  const drawn = async (what, before) => {
    for (let waited = 0; waited < 100_000; waited += 100) {
      const now = pixels();
      if (now.length === before.length && differ(now, before) > 500) return now;
      await new Promise(later => setTimeout(later, 100));
    }
    throw new Error(`${backend}: the page shows nothing new, ${what}: ${note.textContent}`);
  };

  const first = await drawn('opened', new Uint8ClampedArray(4 * 96 ** 2));
  const drop = new page.DataTransfer();
  drop.items.add(new page.File([rod()], 'rod.nrrd'));
  canvas.dispatchEvent(new page.DragEvent('drop', { dataTransfer: drop, cancelable: true }));
  const dropped = await drawn('dropped', first);
  const drag = { buttons: 1, movementX: 60, movementY: 20, bubbles: true };
  canvas.dispatchEvent(new page.PointerEvent('pointermove', drag));
  await drawn('turned', dropped);
  const bad = new page.DataTransfer();
  bad.items.add(new page.File(['NRRD0004\n'], 'bad.nrrd'));
  canvas.dispatchEvent(new page.DragEvent('drop', { dataTransfer: bad, cancelable: true }));
  await new Promise(later => setTimeout(later, 1000));
  if (!note.textContent.includes('bad.nrrd')) await fail(`${backend}: a bad file says '${note.textContent}'`);
  await say(`the page opens, turns and takes files by ${backend}`);
}

// A volume that looks otherwise from every side.
function rod() {
  const [header, n] = ['NRRD0004\ntype: uint8\ndimension: 3\nsizes: 24 24 24\nencoding: raw\n\n', 24];
  const voxels = new Uint8Array(n ** 3).map((_, at) => {
    const [x, y, z] = [at % n, Math.floor(at / n) % n, Math.floor(at / n / n)];
    return x > 2 && x < 21 && Math.abs(y - 8) < 3 && Math.abs(z - 14) < 3 ? 200 : 0;
  });
  return new Blob([header, voxels]);
}

try {
  await main();
} catch (error) {
  await fail(reason(error));
}
await post('/done', '');
