# Other releases of Debian in folders of this machine, as root: what tests/other_systems.sh and tests/packages.sh share. Source it
# after tests/setup.sh; the caller's trap on EXIT calls dismount. SLIPSTEP_MIRROR names another mirror than debootstrap's.

# Mounts go before anything is removed, and a folder that still has some is left alone: they are this machine's own.
mounted=()
dismount() {
  local i
  for ((i = ${#mounted[@]} - 1; i >= 0; i--)); do umount -R "${mounted[i]}" || umount -R -l "${mounted[i]}" || true; done
  mounted=()
}
discard() { # FOLDER
  if grep -qF " $1/" /proc/mounts; then
    echo "left, with mounts: $1" >&2
    return 1
  fi
  rm -rf --one-file-system "$1"
}
# ROOT: what programs expect of a system, from this machine; devices are the few that are needed. Mounts that a run left
# which was killed are taken over. A slave's unmounting does not reach this machine.
enter() {
  local root=$1 folder
  for folder in proc sys dev; do # hwloc complains without sys
    if mountpoint -q "$root/$folder"; then
      true
    elif [ $folder = proc ]; then
      mount -t proc proc "$root/proc" 2>/dev/null || return 1
    else
      mount --rbind "/$folder" "$root/$folder" 2>/dev/null || return 1
    fi
    mount --make-rslave "$root/$folder" || return 1
    mounted+=("$root/$folder")
  done
}

# inside ROOT LOG COMMAND...: nothing of this machine's environment gets in
inside() {
  local root=$1 log=$2
  shift 2
  nice -n 19 chroot "$root" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
    bash -c "$*" >"$log" 2>&1 </dev/null 9>&-
}

# Whether a folder is a release as debootstrap leaves it: the folder /debootstrap is there until that has ended, and
# dpkg knows of nothing half done (or can end it).
complete() { # ROOT
  [ -x "$1/usr/bin/dpkg" ] && [ ! -e "$1/debootstrap" ] || return 1
  inside "$1" /dev/null "dpkg --configure -a && [ -z \"\$(dpkg --audit)\" ] && git --version && test -e /etc/ssl/certs/ca-certificates.crt"
}

reason() { # LOG: what apt-get or debootstrap complained of last
  grep -a '^[EW]: ' "$1" | tail -n 1 | grep . || tail -n 1 "$1"
}

bootstrap() { # RELEASE ROOT LOG: fails with a reason, in why
  why="an incomplete $2 is in the way"
  if [ -e "$2" ]; then discard "$2" || return 1; fi
  why="no debootstrap, and it could not be installed"
  if ! command -v debootstrap >/dev/null; then
    (slipstep_install debootstrap) >"$3" 2>&1 || return 1
    command -v debootstrap >/dev/null || return 1
  fi
  mkdir -p "$2"
  # one hour: a slow mirror, but not one that never answers
  timeout 3600 debootstrap --variant=minbase --include=git,ca-certificates "$1" "$2" ${SLIPSTEP_MIRROR:+"$SLIPSTEP_MIRROR"} >"$3" 2>&1 </dev/null ||
    { why="debootstrap failed: $(reason "$3")"; return 1; }
}

# ROOT: what is needed to reach packages here is needed there
network() {
  local file
  cp -L /etc/resolv.conf "$1/etc/resolv.conf" 2>/dev/null || true
  for file in $(grep -ls '^ *Acquire' /etc/apt/apt.conf /etc/apt/apt.conf.d/*); do cp "$file" "$1$file"; done
}
