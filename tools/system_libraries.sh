#!/bin/sh
# Open3D and the camera driver load a few system libraries that their wheels do not carry. Where they are missing and
# this is a Debian machine on which packages may be installed, install them; otherwise say which.
set -u
python=$1
packages="libusb-1.0-0 libgomp1 libgl1 libegl1 libx11-6"

loads() { "$python" -c 'import open3d, cv2, pyrealsense2' 2>/dev/null; }

loads && exit 0
if command -v apt-get >/dev/null 2>&1; then
    if [ "$(id -u)" = 0 ]; then sudo=""; else sudo="sudo -n"; fi
    echo "installing the system libraries $packages"
    { $sudo apt-get -qq update && $sudo apt-get -qq install --yes --no-install-recommends $packages; } >/dev/null 2>&1
fi
loads && exit 0
echo "difflidar needs the system libraries $packages; please install them" >&2
"$python" -c 'import open3d, cv2, pyrealsense2' 2>&1 | tail -n 1 >&2
exit 2
