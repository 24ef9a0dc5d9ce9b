#!/bin/sh
# Installs the Khronos glTF validator into tests/oracles/node_modules. Needs node and npm. Safe to run again.
set -eu
cd "$(dirname "$0")"
if [ -f node_modules/gltf-validator/package.json ]; then
    echo "gltf-validator is ready"
    exit 0
fi
npm install --no-audit --no-fund --no-package-lock --loglevel=error
echo "gltf-validator is made"
