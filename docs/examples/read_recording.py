"""Read one field of a recording: python3 read_recording.py exchange.mcap fluid/pressure   (pip install mcap numpy)"""
import struct
import sys

import numpy as np
from mcap.reader import make_reader

with open(sys.argv[1], "rb") as file:
    for _, channel, message in make_reader(file, validate_crcs=True).iter_messages(topics=[sys.argv[2]]):
        step, pass_ = struct.unpack_from("<QI", message.data, 16)
        values = np.frombuffer(message.data, "<f8", offset=64).reshape(-1, int(channel.metadata["components"]))
        print(f"step {step} pass {pass_}: {len(values)} values, {values.min():g} to {values.max():g} {channel.metadata['unit']}")
