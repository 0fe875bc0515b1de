import init, { view } from './viewer.js';

const note = document.getElementById('note');
try {
  await init();
  await view('canvas');
  note.remove();
} catch (error) {
  note.textContent = `${error}`;
}
