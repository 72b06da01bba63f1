#!/usr/bin/env bash
# Installs what the tests need beside Python: Chromium for the browser test, Node and one npm package for the
# stranger's reader, OpenNI and libfreenect with their stand-ins for hardware, PostgreSQL's server. Uses apt where it may; elsewhere
# it says in one sentence what to install, and goes on: the tests that need the missing tool then skip (never in
# CI, where CI=true makes them fail).
set -euo pipefail
cd "$(dirname "$0")"

missing=()
command -v chromium >/dev/null || command -v chromium-browser >/dev/null || missing+=(chromium)
command -v node >/dev/null || missing+=(nodejs)
command -v npm >/dev/null || missing+=(npm)
# the browser driver brings a Node of its own, which needs this library
PATH="$PATH:/sbin:/usr/sbin" ldconfig -p 2>/dev/null | grep -q 'libatomic\.so\.1' || missing+=(libatomic1)

# cameras: OpenNI's library with its Dummy device, and libfreenect with fakenect, which plays recordings
has_library() { compgen -G "/usr/lib/*/$1" >/dev/null || [ -e "/usr/lib/$1" ]; }
has_library libOpenNI2.so || missing+=(libopenni2-0 libopenni2-dev)
has_library fakenect/libfreenect.so.0.5 || missing+=(libfreenect0.5)

# the tests start a PostgreSQL server of their own; the package shall make none
if ! compgen -G "/usr/lib/postgresql/*/bin/initdb" >/dev/null && ! command -v initdb >/dev/null; then
  missing+=(postgresql)
  if [ "$(id -u)" = 0 ] && [ ! -e /etc/postgresql-common/createcluster.conf ]; then
    mkdir -p /etc/postgresql-common && echo "create_main_cluster = false" >/etc/postgresql-common/createcluster.conf
  fi
fi

if [ ${#missing[@]} -gt 0 ]; then
  if command -v apt-get >/dev/null && [ "$(id -u)" = 0 ]; then
    export DEBIAN_FRONTEND=noninteractive
    apt-get update -qq
    apt-get install -y -qq --no-install-recommends -o Dpkg::Options::=--force-confold "${missing[@]}" fonts-dejavu-core >/dev/null
  else
    echo "The browser test, the stranger's reader, the camera and PostgreSQL tests need ${missing[*]}: install them (Debian: sudo apt-get install ${missing[*]}) and run make test again." >&2
  fi
fi

if command -v npm >/dev/null && [ ! foreign/node_modules/.installed -nt foreign/package.json ]; then
  (cd foreign && npm install --no-audit --no-fund --no-package-lock --silent && touch node_modules/.installed)
fi
