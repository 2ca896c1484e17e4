# What `./dev package` does; ../dev sources this file.

packaged=$PWD/target/package

# What packaging uses beside the compiler, and what building for a Raspberry Pi uses beside that.
need_packager() {
    # They run for seconds: they need not be compiled for speed.
    local -x CARGO_PROFILE_RELEASE_OPT_LEVEL=1 CARGO_PROFILE_RELEASE_LTO=off CARGO_PROFILE_RELEASE_CODEGEN_UNITS=16
    need_tool cargo-deb 3.8.0
    need_tool mdbook 0.5.4
    command -v cargo-about >/dev/null && return
    say "installing cargo-about 0.9.3 in target/tools"
    CARGO_TARGET_DIR=$tools/build cargo install --quiet --locked --root "$tools" --version 0.9.3 --features cli cargo-about &&
        rm -rf "$tools/build"
}
sysroot=$packaged/sysroot-arm64
need_arm64() {
    [ "$(id -u)" -eq 0 ] || die "the package for arm64 needs root once, to unpack Debian's libraries"
    command -v mmdebstrap >/dev/null && command -v aarch64-linux-gnu-gcc >/dev/null ||
        { apt-get update -qq && apt-get install -y --no-install-recommends mmdebstrap gcc-aarch64-linux-gnu libc6-dev-arm64-cross; } ||
        die "the package for arm64 needs mmdebstrap and gcc for aarch64, which Debian has"
    need_target aarch64-unknown-linux-gnu || die "the package for arm64 needs rustup, which adds the target"
    [ -d "$sysroot/usr" ] && return
    say "unpacking Debian's libraries for arm64 in $sysroot"
    mmdebstrap --quiet --variant=extract --arch=arm64 --include=libasound2-dev,libjack-jackd2-dev \
        "$(sed -n 's/^VERSION_CODENAME=//p' /etc/os-release)" "$sysroot"
}

# Builds the programs for a target, into the folder that is printed.
built_for() {
    local target=$1
    if [ "$target" = aarch64-unknown-linux-gnu ] && [ "$target" != "$host" ]; then
        export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc PKG_CONFIG_ALLOW_CROSS=1
        export PKG_CONFIG_SYSROOT_DIR=$sysroot
        export PKG_CONFIG_LIBDIR=$sysroot/usr/lib/aarch64-linux-gnu/pkgconfig:$sysroot/usr/share/pkgconfig
        export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUSTFLAGS="-Clink-arg=-Wl,-rpath-link,$sysroot/usr/lib/aarch64-linux-gnu"
    fi
    local place=() folder=${CARGO_TARGET_DIR:-$PWD/target}/release
    if [ "$target" != "$host" ]; then
        place=(--target "$target") folder=${CARGO_TARGET_DIR:-$PWD/target}/$target/release
    fi
    cargo build --release --locked "${place[@]}" \
        -p friction-bench -p friction-bench-participant -p mock-nidaqmx >&2
    echo "$folder"
}

# Lays out the tree that is installed. The program of this machine writes its manual pages and completions.
stage() {
    local root=$1 built=$2 program=$3 strip=$4 doc=$1/usr/share/doc/friction-bench
    rm -rf "$root"
    mkdir -p "$root"
    cp -r package/root/. "$root"
    install -D -m 755 -t "$root/usr/bin" "$built/friction-bench" "$built/friction-bench-participant"
    install -D -m 644 -t "$root/usr/lib/friction-bench" "$built/libnidaqmx.so"
    "$strip" "$root"/usr/bin/* "$root/usr/lib/friction-bench/libnidaqmx.so"
    "$program" manual --to "$root/usr/share/man/man1"
    gzip -9n "$root"/usr/share/man/man1/*
    completion() { mkdir -p "$root/usr/share/$2"; "$program" completions "$1" >"$root/usr/share/$2/$3"; }
    completion bash bash-completion/completions friction-bench
    completion zsh zsh/vendor-completions _friction-bench
    completion fish fish/vendor_completions.d friction-bench.fish
    mkdir -p "$doc/bench/hardware/config/rigs"
    cp -r docs README.md LICENSE-MIT LICENSE-APACHE bench/results/plotting/fonts/LICENSE-DejaVu.txt package/debian/README.Debian "$doc"
    cp bench/hardware/config/rigs/*.toml "$doc/bench/hardware/config/rigs"
    gzip -9n <CHANGELOG.md >"$doc/changelog.gz"
    lay_out_book target/handbook-source
    mdbook build --dest-dir "$doc/handbook" target/handbook-source >&2
    licences() {
        cargo about generate --locked --offline --fail --manifest-path "$1" --config package/about.toml package/about.hbs |
            gzip -9n >"$doc/$2.md.gz"
    }
    licences bench/Cargo.toml third-party-licences
    licences bench/operation/participant-window/window/Cargo.toml third-party-licences-participant
    find "$root" -type d -exec chmod 755 {} +
    chmod -R u+w,go+rX,go-w "$root"
}

# Packs the tree, the same bytes from the same tree.
pack() {
    local target=$1 version=$2 name
    local folder=friction-bench-$version-${target%%-*}-linux
    SOURCE_DATE_EPOCH=$(git log -1 --format=%ct 2>/dev/null || stat -c %Y CHANGELOG.md)
    export SOURCE_DATE_EPOCH
    printf 'friction-bench (%s-1) unstable; urgency=medium\n\n  * Release %s; changelog.gz has its changes.\n\n -- %s  %s\n' \
        "$version" "$version" "friction-bench maintainers <maintainers@friction-bench.invalid>" \
        "$(date -u -R -d "@$SOURCE_DATE_EPOCH")" >"$packaged/changelog"
    cargo deb --quiet --compress-system --no-build --no-strip -p friction-bench --target "$target" --output "$packaged/"
    tar --sort=name --mtime="@$SOURCE_DATE_EPOCH" --owner=0 --group=0 --numeric-owner \
        -C "$packaged" --transform "s,^root,$folder," -c root | gzip -9n >"$packaged/$folder.tar.gz"
}

package() {
    local target version host built strip=strip
    host=$(rustc -vV | sed -n 's/^host: //p')
    target=${1:-$host}
    version=$(cargo pkgid --locked -p friction-bench)
    version=${version##*[#@]}
    mkdir -p "$packaged"
    need_packager
    if [ "$target" != "$host" ]; then need_arm64; strip=aarch64-linux-gnu-strip; fi
    say "building for $target"
    built=$(built_for "$target")
    say "staging"
    local program=$built/friction-bench
    if [ "$target" != "$host" ]; then program=$(unset PKG_CONFIG_SYSROOT_DIR PKG_CONFIG_LIBDIR; built_for "$host")/friction-bench; fi
    stage "$packaged/root" "$built" "$program" "$strip"
    say "packing"
    pack "$target" "$version"
    local deb
    deb=$(ls -t "$packaged"/*.deb | head -1)
    if [ "$target" = "$host" ]; then ./package/check.sh "$deb"
    else say "not installed for a test, since it is for another processor"; fi
    du -h --apparent-size "$deb" "$packaged"/*.tar.gz
}
