#!/usr/bin/env bash
# Installs the package on a clean Debian, uses it there as a user would, and removes it again: package/check.sh FILE.deb
# Without root it is unpacked to a folder and used from there.
set -euo pipefail
cd "$(dirname "$0")/.."
deb=$(realpath "$1")
clean=$PWD/target/package/clean.tar
work=$(mktemp -d "$PWD/target/package/check.XXXXXX")
trap 'rm -rf "$work"' EXIT
failures=0

say() { printf '\033[1m== %s\033[0m\n' "$*" >&2; }
passed() { printf 'ok      %s\n' "$1"; }
failed() { printf 'FAILED  %s\n' "$1"; sed 's/^/        /' "$work/output" | tail -20; failures=$((failures + 1)); }
# Whether a command in the installed system ends with this status and prints these words.
expect() {
    local what=$1 status=$2 words=$3 got=0
    shift 3
    as_user "$@" >"$work/output" 2>&1 || got=$?
    if [ "$got" -eq "$status" ] && grep -qE -- "$words" "$work/output"; then passed "$what"
    else echo "(status $got, expected $status and: $words)" >>"$work/output"; failed "$what"; fi
}
# Whether an output of this script holds nothing.
none() {
    if [ -s "$work/output" ]; then failed "$1"; else passed "$1"; fi
}

# ---- the system ----

fields() { dpkg-deb -f "$deb" "$1" | tr ',' '\n' | sed 's/(.*//; s/|.*//; s/ //g' | grep .; }
make_clean() {
    [ -s "$clean" ] && [ "$clean" -nt bench/Cargo.toml ] && return
    local codename
    codename=$(sed -n 's/^VERSION_CODENAME=//p' /etc/os-release)
    command -v mmdebstrap >/dev/null || apt-get install -y --no-install-recommends mmdebstrap >&2
    say "making a clean Debian with what the package depends on, man-db and bash-completion"
    mmdebstrap --quiet --variant=minbase \
        --include="$({ fields Depends; fields Recommends; echo man-db; echo bash-completion; } | sort -u | paste -sd,)" \
        "$codename" "$clean.partial.tar"
    mv "$clean.partial.tar" "$clean"
}
enter() {
    local root=$work/root
    unshare --mount --propagation private sh -c '
        root=$1; shift
        mount -t proc proc "$root/proc" && mount --rbind /dev "$root/dev" && exec chroot "$root" "$@"' enter "$root" "$@"
}
as_root() { enter env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive bash -c "$1"; }
as_user() {
    if [ -n "${root:-}" ]; then
        enter setpriv --reuid=1000 --regid=1000 --init-groups env -i HOME=/home/tester USER=tester PATH=/usr/bin:/bin \
            LANG=C.UTF-8 TERM=xterm ${display:+DISPLAY=$display} bash -c "cd && $1"
    else
        (cd "$work/home" && env -i HOME="$work/home" USER=tester PATH="$work/root/usr/bin:/usr/bin:/bin" LANG=C.UTF-8 TERM=xterm \
            MANPATH="$work/root/usr/share/man:" ${display:+DISPLAY=$display} bash -c "$1")
    fi
}
# Every path but what runs and logs, and the group file, whose contents count too.
trace() {
    find "$work/root" -xdev \( -path "$work/root/proc" -o -path "$work/root/dev" -o -path "$work/root/home" \
        -o -path "$work/root/var/cache/man" -o -path "$work/root/tmp" \) -prune -o -printf '%P\n' | grep -v -- '-old$' | sort
    sort "$work/root/etc/group"
}

mkdir -p "$work/root" "$work/home"
if [ "$(id -u)" -eq 0 ] && unshare --mount true 2>/dev/null; then
    make_clean
    root=$work/root
    tar -C "$root" -xf "$clean"
    as_root 'useradd --create-home --shell /bin/bash tester && groupadd --system other && groupdel other && dpkg --configure -a'
    trace >"$work/before"
    cp "$deb" "$root/tmp/package.deb"
    say "installing"
    as_root 'dpkg -i /tmp/package.deb' >"$work/output" 2>&1 && passed "dpkg installs it with its dependencies alone" ||
        failed "dpkg installs it with its dependencies alone"
    doc=/usr/share/doc/friction-bench prefix=
else
    say "not root: unpacking to a folder"
    dpkg-deb -x "$deb" "$work/root"
    doc=$work/root/usr/share/doc/friction-bench prefix=$work/root
fi

# ---- the program ----

say "using it"
version=$(dpkg-deb -f "$deb" Version)
expect "--version tells version and commit" 0 "^friction-bench ${version%-*} \(.+\)$" 'friction-bench --version'
expect "no library is missing" 1 '^$' "ldd $prefix/usr/bin/* $prefix/usr/lib/friction-bench/*.so | grep 'not found' || { echo; exit 1; }"
expect "the program itself loads no window library" 1 '^$' "ldd $prefix/usr/bin/friction-bench | grep -i libx || { echo; exit 1; }"
expect "demo runs to its results" 0 'Results' 'friction-bench demo'
expect "demo leaves results and figures" 0 '^fig' 'test -s demo/results.json && test -s demo/calibration/calibration.toml && ls demo/figures'
expect "a second demo takes another folder" 0 'demo-2' 'friction-bench demo'
expect "verify finds the study whole" 0 '' 'friction-bench verify demo/study'
expect "init, unattended, writes a bench" 0 'bench.toml' \
    'friction-bench init --mock --rig raspberry-pi --card custom:sim --force-port /dev/ttyUSB0 --force-line frames --plate P1 </dev/null'
expect "a simulated NI card is found by its library" 0 'passed|ok' \
    "friction-bench check --mock --config $doc/bench/hardware/config/rigs/mock-bench-nidaqmx.toml"
expect "participant without a display says what to do" 2 'DISPLAY is not set' 'friction-bench participant'
expect "messages explains one" 0 'display was lost' 'friction-bench messages display lost'
if command -v Xvfb >/dev/null; then
    # Its socket in the abstract namespace is seen from the clean root, too.
    Xvfb -displayfd 3 -screen 0 1024x600x24 -nolisten tcp 3>"$work/number" 2>/dev/null &
    server=$!
    for _ in $(seq 300); do [ -s "$work/number" ] && break; kill -0 $server || break; sleep 0.1; done
    display=:$(cat "$work/number")
    # It waits for sessions until it is told to end.
    expect "participant opens its window" 0 'window|ruler|waiting|screen' \
        'friction-bench participant >said 2>&1 & for i in $(seq 600); do test -S /tmp/*/*.socket && break; test -s said && break; sleep 0.1; done; sleep 2; kill -0 $! && kill -TERM $!; wait $!; cat said; echo window' ||
        true
    display=
    kill $server
fi

# ---- what comes with it ----

say "what comes with it"
expect "the manual has a page" 0 'friction-bench.1' 'man -w friction-bench'
expect "its page is readable" 0 'SUBCOMMANDS|friction-bench-run' 'man friction-bench | cat'
as_user 'friction-bench help' 2>&1 | sed -n 's/^  \([a-z]\+\)  .*/\1/p' | grep -v '^help$' >"$work/commands"
: >"$work/output"
while read -r command; do
    as_user "man -w friction-bench-$command" >/dev/null 2>&1 || echo "$command" >>"$work/output"
done <"$work/commands"
none "every command has a page ($(wc -l <"$work/commands"))"
expect "bash completes a command" 0 '^verify$' \
    'source '"$prefix"'/usr/share/bash-completion/completions/friction-bench; COMP_WORDS=(friction-bench ver); COMP_CWORD=1
     $(complete -p friction-bench | sed "s/.*-F \([^ ]*\).*/\1/") friction-bench ver friction-bench; printf "%s\n" "${COMPREPLY[@]}"'
expect "zsh's and fish's completions are there" 0 'compdef' \
    "head -1 $prefix/usr/share/zsh/vendor-completions/_friction-bench; test -s $prefix/usr/share/fish/vendor_completions.d/friction-bench.fish"
expect "the handbook is a book" 0 'friction-bench handbook' "cat $doc/handbook/index.html"
expect "licences of third parties" 0 '^## Mozilla Public License 2.0' "zcat $doc/third-party-licences.md.gz"
# Files that the program names in its messages.
grep -aohE '(docs|bench)/[A-Za-z0-9_/-]+\.(md|toml)' "$work"/root/usr/bin/* | sort -u >"$work/named"
: >"$work/output"
while read -r file; do
    [ -e "$work/root/usr/share/doc/friction-bench/$file" ] || echo "$file" >>"$work/output"
done <"$work/named"
none "every file that a message names is there ($(wc -l <"$work/named"))"

# ---- gone again ----

if [ -n "${root:-}" ]; then
    say "removing it"
    as_root 'dpkg -r friction-bench && dpkg -P friction-bench' >"$work/output" 2>&1 && passed "dpkg removes and purges it" ||
        failed "dpkg removes and purges it"
    rm -f "$root/tmp/package.deb"
    trace >"$work/after"
    diff "$work/before" "$work/after" >"$work/output" || true
    none "no trace is left"
fi
say "$(basename "$deb"): $(du -h --apparent-size "$deb" | cut -f1) packed, $(dpkg-deb -f "$deb" Installed-Size) kB installed"
[ $failures -eq 0 ] || { say "$failures of the above failed"; exit 1; }
