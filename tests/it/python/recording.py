"""Reads a recording with Foxglove's own library, and prints what is in it as JSON.

With `--cut-off` the file may end anywhere: what comes before is read as a stream.
"""

import json
import sys

from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, make_reader
from mcap_protobuf.decoder import DecoderFactory


def messages(reader, cut_off):
    stream = reader.iter_decoded_messages(log_time_order=False)
    while True:
        try:
            yield next(stream)
        except StopIteration:
            return
        except (McapError, EOFError):
            if not cut_off:
                raise
            return


def main(path, cut_off):
    with open(path, "rb") as file:
        kind = NonSeekingReader if cut_off else make_reader
        reader = kind(file, decoder_factories=[DecoderFactory(), Json()])
        schemas, counts, times = {}, {}, []
        first_frames, frames, parents, entities = set(), set(), set(), set()
        entity_frames = set()
        steps = []
        for schema, channel, message, decoded in messages(reader, cut_off):
            topic = channel.topic
            schemas[topic] = [schema.name, schema.encoding, channel.message_encoding]
            counts[topic] = counts.get(topic, 0) + 1
            times.append(message.log_time)
            if topic == "/tf":
                children = {transform.child_frame_id for transform in decoded.transforms}
                parents |= {transform.parent_frame_id for transform in decoded.transforms}
                frames |= children
                if message.log_time == times[0]:
                    first_frames |= children
                stamps = {
                    transform.timestamp.seconds * 10**9 + transform.timestamp.nanos
                    for transform in decoded.transforms
                }
                assert stamps == {message.log_time}, stamps
            if topic == "/scene":
                for entity in decoded.entities:
                    entities.add(entity.id)
                    entity_frames.add(entity.frame_id)
                    assert entity.frame_locked
            if topic == "/frame":
                steps.append([decoded["episode"], decoded["step"]])
        assert entity_frames <= first_frames, entity_frames - first_frames
        assert all(a <= b for a, b in zip(times, times[1:])), "time goes backwards"
        metadata = {}
        if not cut_off:
            file.seek(0)
            reader = make_reader(file)
            metadata = {record.name: record.metadata for record in reader.iter_metadata()}
        print(
            json.dumps(
                {
                    "schemas": schemas,
                    "counts": counts,
                    "first_frames": sorted(first_frames),
                    "frames": sorted(frames),
                    "parents": sorted(parents),
                    "entities": sorted(entities),
                    "steps": steps,
                    "metadata": metadata,
                    "times": [times[0], times[-1]] if times else [],
                }
            )
        )


class Json:
    def decoder_for(self, message_encoding, schema):
        return json.loads if message_encoding == "json" else None


if __name__ == "__main__":
    main(sys.argv[1], "--cut-off" in sys.argv)
