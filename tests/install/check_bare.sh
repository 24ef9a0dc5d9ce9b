#!/bin/sh
# A fresh environment with nothing but `pip install .`: the package is whole, works, and says how to install an extra.
#   PYTHON  a Python 3.11 or later; default: python3
set -eu
cd "$(dirname "$0")/../.."
PYTHON="${PYTHON:-python3}"
BARE="$PWD/.venv-bare"
FOLDER="$(mktemp -d)"
trap 'rm -rf "$FOLDER"' EXIT

rm -rf "$BARE"
"$PYTHON" -m venv "$BARE"
"$BARE/bin/python" -m pip install --quiet --disable-pip-version-check .

fail() {
    echo "bare install: $1" >&2
    exit 1
}

files_of() { # folder: its files, without what Python makes of them
    (cd "$1" && find . -type f ! -name '*.py[co]' ! -name .DS_Store | sort)
}

for library in pxr ezc3d av; do
    if "$BARE/bin/python" -c "import $library" 2>/dev/null; then fail "expected no $library, got one"; fi
done
installed="$("$BARE/bin/python" -c 'import os, sysconfig; print(os.path.join(sysconfig.get_path("purelib"), "kinestitch"))')"
files_of src/kinestitch >"$FOLDER/ours"
files_of "$installed" >"$FOLDER/installed"
diff "$FOLDER/ours" "$FOLDER/installed" || fail "expected the files of src/kinestitch, got the others above"

cd "$FOLDER"
"$BARE/bin/kinestitch" --version
"$BARE/bin/kinestitch" demo demo >demo.txt 2>&1 || fail "the demo failed: $(cat demo.txt)"
[ -s demo/walk.bvh ] || fail "expected the demo's clips, got $(ls demo)"
"$BARE/bin/kinestitch" convert demo/walk.bvh walk.glb >/dev/null
"$BARE/bin/kinestitch" convert walk.glb walk.fbx >/dev/null

refused() { # extra, words of the command: one line that names the extra's installation, and exit code 2
    extra="$1"
    shift
    code=0
    "$BARE/bin/kinestitch" "$@" >out.txt 2>err.txt || code=$?
    [ "$code" = 2 ] || fail "expected exit code 2 of 'kinestitch $*', got $code: $(cat err.txt)"
    [ "$(cat out.txt err.txt | wc -l)" -eq 1 ] || fail "expected one line of 'kinestitch $*', got: $(cat out.txt err.txt)"
    grep -qF "pip install 'kinestitch[$extra]'" err.txt || fail "expected the extra $extra, got: $(cat err.txt)"
    echo "kinestitch $*: $(cat err.txt)"
}

printf '#usda 1.0\n' >clip.usda
printf 'trial' >trial.c3d
refused usd info clip.usda
refused usd convert clip.usda clip.bvh
refused usd convert demo/walk.bvh walk.usdc
refused c3d info trial.c3d
refused video video demo/walk.bvh -o walk.mp4
[ ! -e walk.usdc ] && [ ! -e walk.mp4 ] || fail "expected no output of a refused command, got $(ls)"
echo "bare install: whole, works, and names the extras that miss"
