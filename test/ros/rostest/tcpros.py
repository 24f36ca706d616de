"""Neighbours that no client library can be, ill-behaved or without a master: a publisher and a subscriber that speak TCPROS
by hand."""
import socket
import struct
import threading
import xmlrpc.client
from io import BytesIO
from xmlrpc.server import SimpleXMLRPCServer

import rosgraph

from graph import TIMEOUT


def header(**fields):
    """A connection header: a length, and "name=value" with a length each."""
    lines = [("%s=%s" % field).encode() for field in fields.items()]
    text = b"".join(struct.pack("<I", len(line)) + line for line in lines)
    return struct.pack("<I", len(text)) + text


def receive(connection):
    """The bytes that come after their length."""
    length, = struct.unpack("<I", connection.recv(4, socket.MSG_WAITALL))
    return connection.recv(length, socket.MSG_WAITALL)


def serialized(message):
    """A message as it is sent, with its length."""
    buffer = BytesIO()
    message.serialize(buffer)
    return struct.pack("<I", buffer.tell()) + buffer.getvalue()


class RawPublisher:
    """Registered like any publisher. With a `payload` each subscriber that connects is sent these bytes, and hung up on."""

    def __init__(self, name, topic, kind, payload=None, master_uri=None):
        self.name, self.topic, self.kind, self.payload = name, topic, kind, payload
        self.master_uri = master_uri or rosgraph.get_master_uri()
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.api = SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False, allow_none=True)
        self.api.register_function(self.request_topic, "requestTopic")
        self.uri = "http://127.0.0.1:%d/" % self.api.server_address[1]
        self.served = []
        for work in (self.api.serve_forever, self.serve):
            threading.Thread(target=work, daemon=True).start()
        self.call("registerPublisher", topic, kind._type, self.uri)

    def call(self, method, *arguments):
        getattr(xmlrpc.client.ServerProxy(self.master_uri), method)(self.name, *arguments)

    def request_topic(self, caller, topic, protocols):
        return [1, "", ["TCPROS", "127.0.0.1", self.listener.getsockname()[1]]]

    def serve(self):
        while True:
            try:
                connection, _ = self.listener.accept()
            except OSError:
                return  # closed
            receive(connection)
            connection.sendall(header(callerid=self.name, topic=self.topic, type=self.kind._type, md5sum=self.kind._md5sum,
                                      latching="0", message_definition="") + (self.payload or b""))
            if self.payload is not None:
                connection.close()
            self.served.append(connection)

    def publish(self, message):
        for connection in self.served:
            connection.sendall(serialized(message))

    def close(self):
        self.call("unregisterPublisher", self.topic, self.uri)
        self.listener.close()
        self.api.shutdown()
        self.api.server_close()


class RawSubscriber:
    """Connects to the publisher of a topic, and reads only when asked to."""

    def __init__(self, name, topic, kind, master_uri=None):
        master = rosgraph.Master(name, master_uri)
        publishers = dict(master.getSystemState()[0])[topic]
        api = xmlrpc.client.ServerProxy(master.lookupNode(publishers[0]))
        _, _, (_, host, port) = api.requestTopic(name, topic, [["TCPROS"]])
        self.kind, self.met = kind, False
        self.connection = socket.create_connection((host, port), TIMEOUT)
        self.connection.sendall(header(callerid=name, topic=topic, type=kind._type, md5sum=kind._md5sum))

    def read(self):
        """The next message; socket.timeout where none comes."""
        if not self.met:
            receive(self.connection)
            self.met = True
        message = self.kind()
        message.deserialize(receive(self.connection))
        return message

    def close(self):
        self.connection.close()
