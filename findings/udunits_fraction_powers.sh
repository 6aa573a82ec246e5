#!/usr/bin/env bash
# UDUNITS takes fractional powers for products: "MPa m^0.5" is 5 MPa, and "MPa m0.5" half a MPa.
#
# Seen with UDUNITS 2.2.28 (Debian 12), the library behind the units of CF, cf-units, NCO and others. Fracture toughness and stress
# intensity have the unit MPa m^0.5. The exponent ends at the point: "MPa m^0.5" is read as MPa times m^0 times 5, "MPa m0.5" as MPa times
# m^0 times 0.5, and "Pa m^-0.5" as 5 Pa. All are accepted, can be converted to Pa (not to Pa m, say), and give numbers that are wrong by
# such factors, without a warning; "m^1/2" is half a metre. Only "m^(1/2)" is refused, as units of this library have integer powers. Keep
# such numbers in Pa^2 m, or their unit out of the attribute "units".
#
# Guess before the run: an error, or the square root.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
apt-get -qq download udunits-bin=2.2.28-5 libudunits2-0=2.2.28-5 libudunits2-data=2.2.28-5 libexpat1 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
for deb in *.deb; do dpkg -x "$deb" tree; done
export UDUNITS2_XML_PATH=$room/tree/usr/share/xml/udunits/udunits2.xml
export LD_LIBRARY_PATH=$room/tree/usr/lib/x86_64-linux-gnu:$room/tree/lib/x86_64-linux-gnu

seen=true
check() { # UNIT TO ANSWER
  local said
  said=$({ tree/usr/bin/udunits2 -H "$1" -W "$2" 2>&1 || true; } | head -1 | sed 's/^ *//')
  echo "$1 in $2: $said"
  [[ $said == "$3" ]] || seen=false
}
check "MPa m" "Pa m" "1 MPa m = 1e+06 (Pa m)"
check "MPa m^0.5" Pa "1 MPa m^0.5 = 5e+06 Pa"
check "MPa m0.5" Pa "1 MPa m0.5 = 500000 Pa"
check "MPa m**0.5" Pa "1 MPa m**0.5 = 5e+06 Pa"
check "Pa m^-0.5" Pa "1 Pa m^-0.5 = 5 Pa"
check "MPa m^1.5" "Pa m" "1 MPa m^1.5 = 5e+06 (Pa m)"
check "m^1/2" m "1 m^1/2 = 0.5 m"
check "MPa m^0.5" "Pa m" "udunits2: Units are not convertible"
check "MPa m^(1/2)" Pa "udunits2: Don't recognize \"MPa m^(1/2)\""
$seen
