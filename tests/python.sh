#!/bin/sh
# python.sh FOLDER: examples/python on the library in FOLDER, where there is a Python with NumPy; compared with
# scipy.spatial where that is installed too, and with FOLDER/pbw.
for python in "${PYTHON:-python3}" /usr/bin/python3; do
    for modules in numpy,scipy.spatial numpy; do
        if "$python" -c "import $modules" > /dev/null 2>&1; then
            PBW_LIBRARY="$1/libpbw_python.so" PYTHONPATH=examples/python PYTHONDONTWRITEBYTECODE=1 \
                exec "$python" tests/python.py
        fi
    done
done
echo "skipped examples/python: no Python with NumPy"
echo "0 passed, 0 failed, 1 skipped"
