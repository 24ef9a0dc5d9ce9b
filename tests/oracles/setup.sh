#!/bin/sh
# Makes the two environments that the oracle tests ask: .venv-ufbx and .venv-bpy at the checkout's root.
# They are kept apart from .venv because bpy wants numpy < 2. Safe to run again: what stands and works is left alone.
#   sh setup.sh [all | ufbx | bpy]
#   PYTHON  a Python 3.11 (bpy 4.5 exists for no other); default: python3.11
set -eu
cd "$(dirname "$0")/../.."
PYTHON="${PYTHON:-python3.11}"

make_environment() { # folder, module to import, requirements...
    folder="$1"; module="$2"; shift 2
    if [ -x "$folder/bin/python" ] && "$folder/bin/python" -c "import numpy, $module" >/dev/null 2>&1; then
        echo "$folder is ready"
        return
    fi
    rm -rf "$folder"
    "$PYTHON" -m venv "$folder"
    "$folder/bin/python" -m pip install --quiet --disable-pip-version-check "$@"
    "$folder/bin/python" -c "import numpy, $module"
    echo "$folder is made"
}

case "${1:-all}" in all | ufbx) make_environment .venv-ufbx ufbx "ufbx==0.0.5" "numpy>=1.26" ;; esac
case "${1:-all}" in all | bpy) make_environment .venv-bpy bpy "bpy==4.5.*" "numpy<2" ;; esac
