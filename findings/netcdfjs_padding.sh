#!/usr/bin/env bash
# netcdfjs returns the padding of short and byte variables as data, and cannot read one that stands alone.
#
# Seen with netcdfjs 4.0.0 on Node.js 20; the files are made, and read for comparison, by ncgen and ncdump of netCDF 4.9.0
# (Debian 12). The classic format pads a variable to a multiple of four bytes. Three shorts take six bytes and two of padding:
# netcdfjs returns four numbers, the last of them the fill value -32767, for a variable of dimension 3, and in each record of one
# along the unlimited dimension. The format leaves the padding out where a file has a single record variable of such a
# type; there netcdfjs reads past the end and raises "Offset is outside the bounds of the DataView".
#
# Guess before the run: three numbers a record, as the dimension says.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
npm install --silent --no-audit --no-fund --prefix . netcdfjs@4.0.0 >npm.log 2>&1 || { tail -3 npm.log; exit 77; }
mkdir -p debs/partial tree && : >status
apt-get -qq -y -o Dir::State::status="$room/status" -o Dir::Cache::archives="$room/debs" -o Debug::NoLocking=1 \
  --no-install-recommends --download-only install netcdf-bin=1:4.9.0-3+b1 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
rm -f debs/libc6_*.deb
for deb in debs/*.deb; do dpkg -x "$deb" tree; done
netcdf() { LD_LIBRARY_PATH=tree/usr/lib/x86_64-linux-gnu:tree/lib/x86_64-linux-gnu "tree/usr/bin/$@"; }

cat >two.cdl <<'CDL'
netcdf two {
dimensions: time = UNLIMITED; cell = 3;
variables: double time(time); short flag(time, cell); short fault(cell);
data: time = 0, 1; flag = 10, 11, 12, 20, 21, 22; fault = 1, 2, 3;
}
CDL
cat >one.cdl <<'CDL'
netcdf one {
dimensions: time = UNLIMITED; cell = 3;
variables: short flag(time, cell);
data: flag = 10, 11, 12, 20, 21, 22;
}
CDL
for name in one two; do netcdf ncgen -k classic -o $name.nc $name.cdl; done
echo "ncdump: $(netcdf ncdump -v flag,fault two.nc | sed -n '/^data:/,$p' | tr -d '\n')"
netcdf ncdump -v flag one.nc | grep -q '20, 21, 22'

cat >try.mjs <<'JS'
import { NetCDFReader } from "netcdfjs";
import fs from "fs";
const two = new NetCDFReader(fs.readFileSync("two.nc"));
const flag = JSON.stringify(two.getDataVariable("flag")), fault = JSON.stringify(two.getDataVariable("fault"));
console.log("netcdfjs: flag", flag, "fault", fault);
let raised = "";
try {
  new NetCDFReader(fs.readFileSync("one.nc")).getDataVariable("flag");
} catch (error) {
  raised = error.message;
}
console.log("netcdfjs, the only record variable:", raised || "read");
process.exit(flag === "[[10,11,12,-32767],[20,21,22,-32767]]" && fault === "[1,2,3,-32767]" && /outside the bounds/.test(raised) ? 0 : 1);
JS
node try.mjs
