#!/usr/bin/env bash
# The environment of one program of the audit: audits/environments.sh NAME [FOLDER]
#
# Makes a virtual environment FOLDER/NAME (FOLDER is audits/.environments unless given) with the program from the Python
# package index, and prints the interpreter that runs its adapter. For programs of Debian's it prints the packages that
# are needed where they are missing, and the interpreter with what has to stand before it.
set -euo pipefail

usage() {
    echo "usage: audits/environments.sh NAME [FOLDER], where NAME is one of" >&2
    echo "  scipy calfem pyyeti opensees structdyn sdof exudyn mfem kratos" >&2
    echo "  ross easyfea sfepy getfem petsc siconos calculix akantu fedoo" >&2
    exit 2
}

[ $# -ge 1 ] || usage
name=$1
folder=${2:-$(cd "$(dirname "$0")" && pwd)/.environments}

# What the program's own files need of Debian's, where an import fails without it.
debian() {
    local missing=()
    for package in "$@"; do
        dpkg -s "$package" >/dev/null 2>&1 || missing+=("$package")
    done
    if [ ${#missing[@]} -gt 0 ]; then
        echo "$name needs these of Debian's packages: apt-get install --no-install-recommends ${missing[*]}" >&2
        exit 1
    fi
}

packages() {
    python3 -m venv "$folder/$name"
    "$folder/$name/bin/pip" install --quiet --disable-pip-version-check numpy "$@" >&2
    echo "$folder/$name/bin/python"
}

case $name in
scipy) packages scipy ;;
calfem) packages calfem-python ;;
pyyeti) packages pyyeti ;;
opensees)
    debian libblas3 liblapack3
    packages openseespy==3.7.1.2
    ;;
structdyn) packages structdyn ;;
sdof) packages sdof ;;
exudyn) packages exudyn ;;
mfem) packages mfem ;;
kratos) packages KratosMultiphysics KratosStructuralMechanicsApplication ;;
ross) packages 'plotly<6' ross-rotordynamics ;;
easyfea) packages EasyFEA ;;
sfepy) packages sfepy ;;
akantu) packages akantu ;;
fedoo) packages fedoo ;;
getfem | siconos)
    debian "python3-${name%%_*}"
    echo /usr/bin/python3
    ;;
petsc)
    debian python3-petsc4py
    modules=$(dpkg -L python3-petsc4py-real3.18 2>/dev/null | grep -m1 '/dist-packages/petsc4py$' || true)
    echo "env PYTHONPATH=$(dirname "${modules:-$(find /usr/lib/petscdir -type d -name petsc4py | head -n 1)}") /usr/bin/python3"
    ;;
calculix)
    debian calculix-ccx
    echo /usr/bin/python3
    ;;
*) usage ;;
esac
