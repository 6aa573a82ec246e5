#!/usr/bin/env bash
# jsfive reads chunks that were never written as holes, not as the fill value.
#
# Seen with jsfive 0.4.2 and, as the writer and a second reader, h5wasm 0.10.3 (HDF5 compiled to WebAssembly), Node.js 20.
# A dataset grows along its first dimension and its last rows are not written yet, as those of a run that goes on are.
# HDF5 promises the dataset's fill value there, and h5wasm returns it. jsfive knows the value (`fillvalue`), yet the array
# has the right length and empty items where the chunk is missing: JSON turns them into null, a sum into NaN, and
# forEach passes them over.
#
# Guess before the run: the fill value, as every other reader returns it.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
npm install --silent --no-audit --no-fund --prefix . jsfive@0.4.2 h5wasm@0.10.3 >npm.log 2>&1 || { tail -3 npm.log; exit 77; }

cat >try.mjs <<'JS'
import h5wasm from "h5wasm/node";
import { createRequire } from "module";
import fs from "fs";
const jsfive = createRequire(import.meta.url)("jsfive");
await h5wasm.ready;

let file = new h5wasm.File("grow.h5", "w");
file.create_dataset({ name: "slip", data: new Float64Array([1, 2, 3, 4, 5, 6]), shape: [2, 3], maxshape: [null, 3], chunks: [2, 3] });
file.get("slip").resize([5, 3]);
file.close();

file = new h5wasm.File("grow.h5", "r");
const right = Array.from(file.get("slip").value);
file.close();
const bytes = fs.readFileSync("grow.h5");
const read = new jsfive.File(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length), "grow.h5").get("slip");
const holes = [...read.value.keys()].filter((i) => !(i in read.value));
console.log("h5wasm:", JSON.stringify(right));
console.log("jsfive:", JSON.stringify(read.value), "length", read.value.length, "holes", holes.length, "fillvalue", read.fillvalue);
const asSeen = right.length === 15 && right.slice(6).every((x) => x === 0) && read.value.length === 15 && holes.length === 9 &&
  holes[0] === 6 && read.value.slice(0, 6).every((x, i) => x === right[i]);
process.exit(asSeen ? 0 : 1);
JS
node try.mjs
