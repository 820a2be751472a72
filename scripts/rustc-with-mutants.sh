#!/bin/sh
# The compiler for a build with planted bugs (src/planted.rs). Cargo calls it for the packages of this workspace
# alone: what they depend on is built as ever.
exec "$@" --cfg etendue_mutants
