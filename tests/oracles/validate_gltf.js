// Prints one JSON list: for each glTF file named on the command line its numbers of errors and warnings, and messages.
"use strict";
const fs = require("fs");
const validator = require("gltf-validator");

async function report(path) {
  const result = await validator.validateBytes(new Uint8Array(fs.readFileSync(path)), { uri: path });
  const { numErrors, numWarnings, numInfos, messages } = result.issues;
  return { path, errors: numErrors, warnings: numWarnings, infos: numInfos, messages };
}

Promise.all(process.argv.slice(2).map(report)).then((reports) => console.log(JSON.stringify(reports)));
