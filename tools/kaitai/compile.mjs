// Compiles the grammar named on the command line and prints the Python module that it becomes.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

// The packages lie where this runs, not beside this file.
const require = createRequire(`${process.cwd()}/`);
const compiler = require("kaitai-struct-compiler");
const { parse } = require("yaml");

const grammar = parse(readFileSync(process.argv[2], "utf8"));
const files = await compiler.compile("python", grammar, null, false);
const sources = Object.values(files);
if (sources.length !== 1) {
  throw new Error(`one grammar gave ${sources.length} modules`);
}
process.stdout.write(sources[0]);
