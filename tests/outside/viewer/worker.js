import init, { draw } from './viewer.js';

await init();
draw();
