import init, { work } from './viewer.js';

await init();
work();
