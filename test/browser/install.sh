#!/bin/sh
# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
#
# install.sh FOLDER: a headless Chromium for the tests, out of a package of npm that ships the
# program with all libraries beyond glibc and a font. Needs npm, node and tar.
set -eu

package=@sparticuz/chromium@153.0.0
folder=$1
rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"
npm pack --silent --pack-destination . "$package" >/dev/null
tar -xzf ./*.tgz
for name in chromium.br al2023.tar.br swiftshader.tar.br fonts.tar.br; do
    node -e '
        const fs = require("fs"), zlib = require("zlib");
        fs.writeFileSync(process.argv[2], zlib.brotliDecompressSync(fs.readFileSync(process.argv[1])));
    ' "package/bin/$name" "${name%.br}"
done
tar -xf al2023.tar
tar -xf swiftshader.tar
tar -xf fonts.tar
cat >fonts.conf <<END
<?xml version="1.0"?>
<!DOCTYPE fontconfig SYSTEM "fonts.dtd">
<fontconfig><dir>$folder/fonts</dir><cachedir>$folder/cache</cachedir></fontconfig>
END
chmod +x chromium
rm -rf package ./*.tgz ./*.tar
echo "$package" >installed
