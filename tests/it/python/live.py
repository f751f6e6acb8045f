"""Connects to a running training as Foxglove does, and prints what is served as JSON."""

import json
import struct
import sys
import time

import websocket

connection = websocket.create_connection(
    sys.argv[1], subprotocols=["foxglove.sdk.v1"], timeout=60
)
channels, counts, name = {}, {}, None
deadline = time.monotonic() + 60
while time.monotonic() < deadline and counts.get("/action", 0) < 60:
    kind, data = connection.recv_data()
    if kind == websocket.ABNF.OPCODE_TEXT:
        message = json.loads(data)
        if message["op"] == "serverInfo":
            name = message["name"]
        if message["op"] == "advertise":
            channels.update({channel["id"]: channel for channel in message["channels"]})
            asked = [{"id": id, "channelId": id} for id in channels]
            connection.send(json.dumps({"op": "subscribe", "subscriptions": asked}))
    elif kind == websocket.ABNF.OPCODE_BINARY and data[0] == 1:
        (id,) = struct.unpack_from("<I", data, 1)
        topic = channels[id]["topic"]
        counts[topic] = counts.get(topic, 0) + 1
connection.close()
schemas = {channel["topic"]: channel["schemaName"] for channel in channels.values()}
print(json.dumps({"name": name, "schemas": schemas, "counts": counts}))
