// SPDX-License-Identifier: BSD-3-Clause
// SPDX-FileCopyrightText: 2026 the softsim authors
//
// Looks at the page for a while and says what came and was drawn: bytes and frames a second.
//   node watch.mjs PAGE_FOLDER ADDRESS SECONDS
import { launch, open } from './chromium.mjs';

const [pageFolder, address, seconds] = process.argv.slice(2);
const browser = await launch(pageFolder);
const page = await open(browser, address, {});
const look = () => page.evaluate(() => [softsim.link.bytes, softsim.view.frames, performance.now()]);
await page.waitForTimeout(2000);
console.log('counting');
const before = await look();
await page.waitForTimeout(1000 * Number(seconds));
const after = await look();
await browser.close();
const [bytes, frames] = [0, 1].map((k) => (1000 * (after[k] - before[k])) / (after[2] - before[2]));
console.log(`${bytes.toFixed(0)} ${frames.toFixed(1)} ${frames.toFixed(1)}`);
